#pragma once

#include <array>
#include <span>
#include <vector>

namespace livermark::msm {

/// An order of nodes in which neighbours stand close to each other: reverse Cuthill and McKee (Boost.Graph).
/// (Cuthill, McKee 1969, Proc. 24th ACM National Conference; George 1971)
/// @param edges  shape (S), node numbers below num_nodes
/// @return shape (num_nodes), the old number of each new node
std::vector<int> reverse_cuthill_mckee(std::span<const std::array<int, 2>> edges, int num_nodes);

/// The same with nodes next to each other that have about as many neighbours: sorted by falling degree within windows
/// of 256. (Kreutzer et al. 2014, SIAM J. Sci. Comput. 36(5))
std::vector<int> order_by_degree(std::span<const std::array<int, 2>> edges, int num_nodes);

} // namespace livermark::msm
