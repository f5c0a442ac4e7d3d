#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace livermark::msm {

/// Tetrahedra around an edge, each of which shares a face with the next: (axis, rim k, rim k + 1) is tetrahedron k,
/// with the sign of its volume kept. One new node is enough for each but the first.
struct Fan {
    std::array<int, 2> axis;
    std::vector<int> rim;        ///< (m + 1) node numbers; the first and the last are the same where the fan is closed
    std::vector<int> tetrahedra; ///< (m) numbers
};

/// A tetrahedron as one of those around an edge: (edge, from, to) is an even permutation of its corners.
struct Link {
    int tetrahedron, from, to;
};
struct EdgeLink {
    std::array<int, 2> edge; ///< lower node number first
    Link link;
};

/// A tetrahedron as one around one of its edges.
/// @param edge  as in core::tetrahedron_edges
EdgeLink edge_link(const std::array<int, 4> &nodes, int tetrahedron, std::size_t edge);

/// The tetrahedra around all edges, those of one edge behind each other.
std::vector<EdgeLink> edge_links(const std::vector<std::array<int, 4>> &tetrahedra);

/// Cuts a mesh into fans, long ones first, each tetrahedron in one of them.
/// @param tetrahedra     shape (M), node numbers
/// @param corner_volume  shape (M) or empty; what these say of a node is the same for all tetrahedra of a fan
std::vector<Fan> cut_into_fans(const std::vector<std::array<int, 4>> &tetrahedra,
                               const std::vector<std::array<int, 4>> &corner_volume);

} // namespace livermark::msm
