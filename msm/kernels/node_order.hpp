#pragma once

#include <array>
#include <vector>

namespace livermark::msm {

/// An order of nodes in which neighbours are near each other and those next to each other have about as many
/// neighbours: reverse Cuthill-McKee, then by falling degree within windows of 256 nodes. (Cuthill, McKee 1969, Proc.
/// 24th Nat. Conf. ACM; Kreutzer et al. 2014, SIAM J. Sci. Comput. 36(5) for the windows.)
/// @param edges  shape (S), both ends in [0, num_nodes)
/// @return shape (num_nodes), the old number of each node in the new order
std::vector<int> neighbourly_order(int num_nodes, const std::vector<std::array<int, 2>> &edges);

} // namespace livermark::msm
