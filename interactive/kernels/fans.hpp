#pragma once

#include <array>
#include <vector>

namespace livermark::interactive::kernels {

/// Tetrahedra around an edge, each of which shares a face with the next: tetrahedron k has the nodes of the axis, rim k
/// and rim k + 1. So each but the first brings one new node.
struct Fan {
    std::array<int, 2> axis{};
    std::vector<int> rim;        ///< (m + 1) nodes; the first and the last are the same where the fan is closed
    std::vector<int> tetrahedra; ///< (m) numbers
};

/// Puts each tetrahedron into one fan, greedily: the longest fan that is left comes first, that of the first edge of
/// core::edge_table() among equals.
std::vector<Fan> cut_into_fans(const std::vector<std::array<int, 4>> &tetrahedra);

} // namespace livermark::interactive::kernels
