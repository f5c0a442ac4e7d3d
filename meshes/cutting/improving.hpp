#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/splitting.hpp"

namespace livermark::meshes {

/// Nodes that may not move: on the boundary, and between regions. @return (N)
std::vector<bool> fixed_nodes(const core::TetraMesh &mesh);

/// Moves a node if the tetrahedra around it stay good enough: quality of 0.1, or as much as before.
/// @param star  the tetrahedra at the node
/// @return whether it has moved
bool move_node(core::TetraMesh &mesh, std::span<const int> star, int node, const core::Vector3 &target);

/// Moves nodes at the cut, one by one, so that the worst tetrahedron around each gets better, and merges those that
/// stay bad with a neighbour where that helps. Nodes on the cut stay on it, or where they are if there is no level. The
/// volume of all tetrahedra together stays. Tetrahedra that are taken need a positive volume only.
/// @param split  loses the tetrahedra at edges that vanish; their nodes stay, without a tetrahedron
/// @param level  distance from the cut [m], or nothing
void improve(SplitBody &split, const std::function<double(const core::Vector3 &)> &level);

} // namespace livermark::meshes
