#pragma once

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::segmentation {

/// Changes of who is connected to whom. Each looks at every place once and does not touch one twice; none
/// changes the topology of the body. The returned number says how many changes there were.

/// Collapses short edges where that leaves fair tetrahedra. Borders shrink to fewer nodes of themselves; where two
/// borders inside the body, or one and the boundary, are closer than `tight`, they become one.
/// @param shortest, tight, longest  [m] edges to collapse, edges to collapse across a layer, and edges that must not
///                                  come of it
int collapse_edges(core::TetraMesh &mesh, double shortest, double tight, double longest);

/// Replaces the tetrahedra around an edge inside a region by those of a better triangulation of the ring around it
/// (3-2, 4-4, 5-6, 6-8 swaps; Freitag and Ollivier-Gooch 1997) where the worst of them is below this quality.
int remove_edges(core::TetraMesh &mesh, double quality);

/// 2-3 swaps inside a region where that makes the worse of the two better and it is below this quality.
int swap_faces(core::TetraMesh &mesh, double quality);

/// Gives tetrahedra below this quality that lie flat on the border of their region, two faces on it, to the region on
/// the other side, or takes them away at the boundary.
int peel_flat(core::TetraMesh &mesh, double quality);

} // namespace livermark::segmentation
