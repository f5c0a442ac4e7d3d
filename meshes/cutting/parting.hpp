#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// Distance from the surface of what a tool takes away [m], negative inside of it.
struct ToolLevel {
    /// Value of a point outside the region of the tool.
    std::function<double(const core::Vector3 &)> at;
    std::vector<double> node_values; ///< (N) of the mesh
    std::vector<bool> is_in_region;  ///< (M) the tetrahedra of the region; empty where the tool has none
};

/// @param tool  that takes something away; its region is one of the mesh
ToolLevel tool_level(const CutTool &tool, const core::TetraMesh &mesh);

/// Whole tetrahedra that go: see CutWay::facets.
/// @param tool  that takes something away; its region is one of the mesh
/// @return shape (M)
std::vector<bool> tetrahedra_taken(const CutTool &tool, const core::TetraMesh &mesh);

/// Place where a segment goes through the quadrilateral of a blade: 0 at a, 1 at b; nothing if it does not.
std::optional<double> crossing_of(const BladeCut &blade, const core::Vector3 &a, const core::Vector3 &b);

/// Whether a point is on the side of a blade to which its normal, right-handed about the corners, points.
bool is_above(const BladeCut &blade, const core::Vector3 &point);

/// Smallest distance between the triangles of two surfaces [m]: 0 where they cross, infinity if one has none.
/// @param triangles  corners of each [m], not on one line
double distance_between(std::span<const std::array<core::Vector3, 3>> triangles,
                        std::span<const std::array<core::Vector3, 3>> others);

/// Whether the tool of a cut is one: its numbers are finite, a margin and a thickness are not negative, a normal is not
/// zero, a blade has an area, and the mesh has the region.
/// @throws support::InputError  if it is none
/// @throws CutNotOnBody         if the mesh has no such region
void check_cut(const Cut &cut, const core::TetraMesh &mesh);

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

/// Nodes in the wound around which the boundary of some tetrahedra is not one ring of triangles.
/// @param inside    the tetrahedra
/// @param is_wound  (M, 4)
std::vector<int> pinched_nodes(std::span<const int> inside, std::span<const std::array<int, 4>> tetrahedra,
                               const std::vector<std::array<int, 4>> &neighbours, const Faces &is_wound);

/// A body whose tetrahedra are split where a cut goes through them. Its volume is that of the body before, to rounding.
struct SplitBody {
    core::Body body;
    std::vector<int> parent_tetrahedron; ///< (M') ascending
    std::vector<bool> is_on_cut;         ///< (N') nodes on the surface of the cut
    std::vector<bool> taken;             ///< (M') what is inside of what the tool takes away
};

/// Splits tetrahedra along the surface of what a tool takes away, so that each part is inside or outside. A blade
/// thinner than the edges is met by a node on its middle surface in each edge that goes through.
/// @param tool  that takes something away; its region is one of the mesh
SplitBody split_along(const core::Body &body, const CutTool &tool);

/// Splits tetrahedra along a blade without thickness; nothing is taken.
SplitBody split_along_blade(const core::Body &body, const BladeCut &blade);

} // namespace livermark::meshes
