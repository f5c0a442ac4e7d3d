#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Undamped free vibrations of a constrained body, K phi = omega^2 M phi, the lowest first.
struct Modes {
    std::vector<double> angular_frequency; ///< (C) omega [rad/s], ascending
    std::vector<Vector3> shape;            ///< (C, N) phi at the mesh nodes [kg^-1/2], scaled so that phi^T M phi = 1
    std::int64_t degrees_of_freedom = 0;   ///< unknowns, constrained ones included
    double seconds = 0.0;                  ///< for all of it, from the mesh to the modes

    int count() const { return static_cast<int>(angular_frequency.size()); }

    /// (N) the shape of one mode
    std::span<const Vector3> shape_of(int mode) const {
        const auto num_nodes = shape.size() / angular_frequency.size();
        return std::span(shape).subspan(mode * num_nodes, num_nodes);
    }
};

/// Modal assurance criterion of two shapes (Allemang and Brown 1982), 1 where they differ by a factor only and 0 where
/// they have nothing in common: (a . b)^2 / (a . a)(b . b) with a . b = sum_i V_i a_i . b_i, V_i barycentric nodal
/// volume.
/// @param a, b  shape (N), not zero everywhere
double modal_assurance(const TetraMesh &mesh, std::span<const Vector3> a, std::span<const Vector3> b);

} // namespace livermark::core
