#pragma once

#include <array>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/problem.hpp"

namespace livermark::core {

/// Red refinement: every tetrahedron into eight of the same volume. Its four corners are cut off at the middles of its
/// edges, and the octahedron that is left is cut into four along the shortest of its three diagonals, which keeps the
/// shape from degrading however often it is done. A boundary triangle is cut into four, still outward.
///
/// The nodes of the body come first and keep their numbers; the middle of edge e of edge_table() is node N + e.
/// The children of tetrahedron t are 8 t ... 8 t + 7, those of boundary triangle f are 4 f ... 4 f + 3. Children have
/// the region and the patch of their parent. Outer faces stay flat: the body is the same set of points.
/// @param body  tetrahedra of positive volume; every edge of a boundary triangle is an edge of a tetrahedron
/// @throws std::invalid_argument if a boundary triangle has an edge that no tetrahedron has
Body refine(const Body &body);

/// The load case on the refined body: every child of a boundary triangle has the condition of its parent.
/// @param coarse  the mesh that it was put on
LoadCase refine(const LoadCase &load_case, const TetraMesh &coarse);

/// Both. The fine body is made anew at each call; keep it where several load cases share it.
Problem refine(const Problem &problem);

/// A body with some of its tetrahedra bisected. Its first nodes are those of the body that it was made from.
struct BisectedBody {
    Body body;
    std::vector<int> parent_tetrahedron;         ///< (M') the tetrahedron that each is a part of, ascending
    std::vector<int> parent_triangle;            ///< (T') the boundary triangle that each is a part of
    std::vector<std::array<int, 2>> parent_edge; ///< (N' - N) the edge on which each new node is
};

/// Splits edges at a point of each, the longest first in each tetrahedron, with all tetrahedra and boundary triangles
/// at them. Which one is the longest is the same from both sides of a face, so the parts fit together. (M. C. Rivara
/// 1984, Algorithms for refining triangular grids suitable for adaptive and multigrid techniques, Int. J. Numer. Meth.
/// Engng. 20)
/// @param points  [m] between the ends of each edge, which has its lower node number first
BisectedBody split_edges(const Body &body, const std::map<std::array<int, 2>, Vector3> &points);

/// The same in the middle of edges.
/// @param edges  lower node number first
BisectedBody bisect(const Body &body, const std::set<std::array<int, 2>> &edges);

/// A load case on the parts of the mesh that it was put on.
LoadCase on_parts(const LoadCase &load_case, const BisectedBody &parts);

/// Nodes where the condition of the boundary changes: from constrained to free, from one constraint or traction to
/// another. Displacements and tractions are not smooth there.
std::vector<bool> rim_nodes(const TetraMesh &mesh, const LoadCase &load_case);

/// A problem on a mesh that is finer in places. The nodes of the mesh come first.
struct BisectedProblem {
    Problem problem;
    std::vector<int> parent_tetrahedron; ///< (M') see BisectedBody
};

/// Each tetrahedron at the rim of a place has all its edges cut in two.
BisectedProblem refine_at_rims(const Problem &problem);

/// The same, and each tetrahedron at further nodes.
/// @param is_further  (N)
BisectedProblem refine_at_rims_and(const Problem &problem, const std::vector<bool> &is_further);

/// Each tetrahedron whose centroid is nearer to the middle of a place inside than so many of its radii has all its
/// edges cut in two.
BisectedProblem refine_near_places(const Problem &problem, std::span<const InteriorPlace> places, double radii);

/// Each tetrahedron at a rim has all its edges cut in two, and so has each whose centroid is nearer to the middle of a
/// place than so many of its radii and half of the tetrahedron's longest edge: also a place that is smaller than an
/// edge has some.
BisectedProblem refine_at_rims_and_near(const Problem &problem, std::span<const InteriorPlace> places, double radii);

/// The same as refine_at_rims() again and again.
/// @param levels  how often
Problem refine_at_rims(const Problem &problem, int levels);

/// The longest edge that tetrahedra below round tools keep, over their distance from the middle of the tool, or over
/// its radius where that is more. Below Hertz's pressure strains change over the radius, and farther away over the
/// distance, as those below a force on one point.
inline constexpr double longest_edge_below_tools = 0.5;

/// Tetrahedra at the rims of places have all their edges cut in two, and so have those whose longest edge is too long
/// for a round tool above them. What ends at the facets that a round tool touches is no rim: its pressure is zero
/// before.
/// @param longest_edge  as above, over the distance
BisectedProblem refine_at_rims_and_tools(const Problem &problem, double longest_edge = longest_edge_below_tools);

} // namespace livermark::core
