#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/parting.hpp"

namespace livermark::meshes {

/// What is left of a cut mesh, and what had to go so that it holds together.
struct CleanMesh {
    std::vector<std::vector<int>> pieces;      ///< numbers of tetrahedra, ascending; the largest volume first
    std::vector<std::array<bool, 4>> is_wound; ///< (M) faces on the new surface, of the tetrahedra in pieces
    int num_crumbs = 0, num_spikes = 0, num_bridges = 0, num_hinges = 0; ///< see CutBody
};

/// Takes away what does not hold: pieces of less than a hundredth of all volume, tetrahedra on one face that have two
/// more in the wound, tetrahedra in the wound that alone join two parts, and what makes edges and nodes of the wound
/// belong to two parts of it. Again and again until nothing is left of it.
/// @param alive       (M) what the cut left
/// @param neighbours  (M, 4) of all tetrahedra, see core::face_neighbours()
/// @param was_outer   (M, 4) faces on the boundary before the cut
CleanMesh clean_up(const core::TetraMesh &mesh, std::vector<bool> alive,
                   const std::vector<std::array<int, 4>> &neighbours, const Faces &was_outer);

/// The tetrahedra around a node, by what hangs together by faces at it. The first group has the first tetrahedron.
/// @param star   the tetrahedra at the node
/// @param joins  (tetrahedron, face) -> whether the face, which has another tetrahedron of the star behind it, joins
std::vector<std::vector<int>> groups_at_node(int node, std::span<const int> star,
                                             std::span<const std::array<int, 4>> tetrahedra,
                                             const std::vector<std::array<int, 4>> &neighbours,
                                             const std::function<bool(int, std::size_t)> &joins);

/// Nodes in the wound around which the boundary of some tetrahedra is not one ring of triangles.
/// @param inside    the tetrahedra
/// @param is_wound  (M, 4)
std::vector<int> pinched_nodes(std::span<const int> inside, std::span<const std::array<int, 4>> tetrahedra,
                               const std::vector<std::array<int, 4>> &neighbours, const Faces &is_wound);

} // namespace livermark::meshes
