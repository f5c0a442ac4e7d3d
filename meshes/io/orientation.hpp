#pragma once

#include <array>
#include <span>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// The corners of a tetrahedron, the last two exchanged where its volume would be negative.
/// @param nodes   node numbers, indices into points
/// @param points  (N) [m]
inline std::array<int, 4> with_positive_volume(std::array<int, 4> nodes, std::span<const core::Vector3> points) {
    if (core::signed_volume(points[nodes[0]], points[nodes[1]], points[nodes[2]], points[nodes[3]]) < 0.0)
        std::swap(nodes[2], nodes[3]);
    return nodes;
}

} // namespace livermark::meshes
