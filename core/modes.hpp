#pragma once

#include <cstdint>
#include <vector>

#include "core/tetra_mesh.hpp"

namespace livermark::core {

/// Undamped free vibrations of a constrained body, K phi = omega^2 M phi, the lowest first.
struct Modes {
    std::vector<double> angular_frequency; ///< (C) omega [rad/s], ascending
    std::vector<Vector3> shape;            ///< (C, N) phi at the mesh nodes [kg^-1/2], scaled so that phi^T M phi = 1
    std::int64_t degrees_of_freedom = 0;   ///< unknowns, constrained ones included
    double seconds = 0.0;                  ///< for all of it, from the mesh to the modes

    int count() const { return static_cast<int>(angular_frequency.size()); }
};

} // namespace livermark::core
