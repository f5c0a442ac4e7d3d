#pragma once

#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// What displacements of the nodes make of a mesh, with straight edges between them.
struct Deformation {
    double volume_change = 0.0;     ///< (v - V) / V of the whole body
    double smallest_jacobian = 0.0; ///< least ratio of the volumes of a tetrahedron, after and before
    int num_inverted = 0;           ///< tetrahedra whose volume is not positive any more
    std::vector<Vector3> centroid;  ///< (R) of each region, where it is now [m]
};

/// @param displacement  shape (N) [m]; what is not finite gives figures that are not finite, and counts as inverted
/// @throws std::invalid_argument if it has another size
Deformation deformation(const TetraMesh &mesh, std::span<const Vector3> displacement);

} // namespace livermark::core
