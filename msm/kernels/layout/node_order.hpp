#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace livermark::msm {

/// An order of nodes in which neighbours stand close to each other: reverse Cuthill and McKee (Boost.Graph).
/// (Cuthill, McKee 1969, Proc. 24th ACM National Conference; George 1971)
/// @param edges  shape (S), node numbers below num_nodes
/// @return shape (num_nodes), the old number of each new node
std::vector<int> reverse_cuthill_mckee(std::span<const std::array<int, 2>> edges, int num_nodes);

/// Sorts within windows of that many, so that what is alike stands side by side and stays near where it was.
template <class T, class Less> void sort_in_windows(std::vector<T> &items, std::size_t window, const Less &less) {
    for (std::size_t first = 0; first < items.size(); first += window) {
        const auto begin = items.begin() + static_cast<std::ptrdiff_t>(first);
        const auto end = items.begin() + static_cast<std::ptrdiff_t>(std::min(first + window, items.size()));
        std::stable_sort(begin, end, less);
    }
}

/// Reverse Cuthill-McKee order with nodes next to each other that have about as many neighbours: sorted by falling
/// degree within windows of 256. (Kreutzer et al. 2014, SIAM J. Sci. Comput. 36(5))
std::vector<int> order_by_degree(std::span<const std::array<int, 2>> edges, int num_nodes);

} // namespace livermark::msm
