#pragma once

#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::segmentation {

/// Who is whose neighbour in a mesh of several regions.
struct MeshLinks {
    std::vector<std::vector<int>> tetrahedra_of; ///< (N) numbers of the tetrahedra at a node, ascending
    std::vector<std::array<int, 4>> neighbour;   ///< (M) tetrahedron across the face opposite each corner, -1: none
    std::vector<std::vector<int>> labels_of;     ///< (N) regions that meet at a node, `outside` first if it is there
};

MeshLinks mesh_links(const core::TetraMesh &mesh);

/// The region on the other side of the face opposite a corner, or `outside`.
int region_across(const core::TetraMesh &mesh, const MeshLinks &links, int tetrahedron, int corner);

/// 0 to 3, where a node is among the corners of a tetrahedron, or -1.
int corner_of(const std::array<int, 4> &nodes, int node);

/// The tetrahedra at both nodes, ascending.
std::vector<int> tetrahedra_at_edge(const core::TetraMesh &mesh, const MeshLinks &links, int a, int b);

/// Regions that meet at an edge, `outside` first if it is there.
std::vector<int> labels_at_edge(const core::TetraMesh &mesh, const MeshLinks &links, int a, int b);

/// Quality 6 sqrt(2) V / l_rms^3 of a tetrahedron of these nodes.
double quality_of(const core::TetraMesh &mesh, const std::array<int, 4> &nodes);

double mean_edge_length(const core::TetraMesh &mesh); ///< [m]

/// Takes out the tetrahedra that have no region (`outside`), and the nodes that nothing uses.
void drop_unused(core::TetraMesh &mesh);

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
