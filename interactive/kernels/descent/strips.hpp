#pragma once

#include <array>
#include <vector>

namespace livermark::interactive::kernels {

/// A node in a strip of triangles. Each but the first two ends a triangle with two nodes before it, which is none where
/// a strip begins anew.
struct StripNode {
    int node;
    int triangle; ///< its number, or -1 where there is none
    /// The triangle has the node before and the one that the triangle before began with, not that before that: of
    /// (a, b, c) the next one is (a, c, d), not (b, c, d).
    bool keeps_first;
};

/// The triangles as strips, one behind the other: each triangle shares an edge with the one before where that is
/// possible, so that it brings one new node. Greedily, as few strips as a walk from any of the triangles finds.
/// @param triangles  each edge in at most two of them
std::vector<StripNode> cut_into_strips(const std::vector<std::array<int, 3>> &triangles);

} // namespace livermark::interactive::kernels
