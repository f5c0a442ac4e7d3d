#pragma once

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

} // namespace livermark::core
