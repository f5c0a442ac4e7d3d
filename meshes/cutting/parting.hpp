#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// A mesh whose nodes are there twice along some faces.
struct PartedMesh {
    std::vector<core::Vector3> points;          ///< (N') those of the mesh first [m]
    std::vector<std::array<int, 4>> tetrahedra; ///< (M)
    std::vector<int> parent_node;               ///< (N') the node before that each is, or is in the place of
    int num_faces = 0;                          ///< how many are parted
};

/// Faces of a mesh by tetrahedron, each from both sides or none.
using Faces = std::vector<std::array<bool, 4>>;

/// Faces between centroids on either side of a blade.
Faces faces_across(const BladeCut &blade, const core::TetraMesh &mesh);

/// Faces on a blade, along which a body was split.
/// @param is_on_cut  (N) nodes on it
Faces faces_on(const BladeCut &blade, const core::TetraMesh &mesh, const std::vector<bool> &is_on_cut);

/// Parts a mesh along faces: around each node, tetrahedra that hang together by other faces have a node of their own.
/// Faces at whose nodes the new surface would be no manifold stay together, and so does the end of a cut, where no node
/// is there twice.
PartedMesh part_along(const core::TetraMesh &mesh, Faces faces);

/// Remains of a cut mesh, and the parts that had to go so that it holds together.
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
