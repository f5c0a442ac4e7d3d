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

} // namespace livermark::segmentation
