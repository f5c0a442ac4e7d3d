#include "interactive/colouring.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace livermark::interactive {

double chebyshev_weight(int iteration, double last_weight, double rho) {
    if (iteration == 1)
        return 1.0;
    return iteration == 2 ? 2.0 / (2.0 - rho * rho) : 4.0 / (4.0 - rho * rho * last_weight);
}

double chebyshev_rho(int num_iterations) {
    constexpr double largest = 0.95, most_left = 0.1;
    return std::min(largest, 1.0 / std::cosh(std::acosh(1.0 / most_left) / num_iterations));
}

namespace {

std::vector<std::vector<int>> sets_of_nodes(std::span<const std::vector<int>> sets, int num_nodes) {
    std::vector<std::vector<int>> sets_at_node(num_nodes);
    for (std::size_t s = 0; s < sets.size(); ++s)
        for (const int node : sets[s])
            sets_at_node[node].push_back(static_cast<int>(s));
    return sets_at_node;
}

/// Neighbours of each: all that any group names it with.
std::vector<std::vector<int>> neighbours_in(std::span<const std::vector<int>> groups, std::size_t size) {
    std::vector<std::vector<int>> neighbours(size);
    for (const auto &group : groups)
        for (const int a : group)
            for (const int b : group)
                if (a != b)
                    neighbours[a].push_back(b);
    for (auto &list : neighbours) {
        std::ranges::sort(list);
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return neighbours;
}

} // namespace

Colouring by_colours(const std::vector<int> &colour) {
    Colouring result;
    const int num_colours = colour.empty() ? 0 : *std::ranges::max_element(colour) + 1;
    result.offsets.assign(static_cast<std::size_t>(num_colours) + 1, 0);
    for (const int c : colour)
        ++result.offsets[c + 1];
    std::partial_sum(result.offsets.begin(), result.offsets.end(), result.offsets.begin());
    result.order.resize(colour.size());
    auto next = result.offsets;
    for (std::size_t i = 0; i < colour.size(); ++i)
        result.order[next[colour[i]]++] = static_cast<int>(i);
    return result;
}

std::vector<int> colours_of(const Colouring &colouring) {
    std::vector<int> colour(colouring.order.size());
    for (int c = 0; c < colouring.num_colours(); ++c)
        for (int k = colouring.offsets[c]; k < colouring.offsets[c + 1]; ++k)
            colour[colouring.order[k]] = c;
    return colour;
}

Colouring colour_greedily(const std::vector<std::vector<int>> &neighbours) {
    std::vector<int> colour(neighbours.size(), -1);
    std::vector<bool> is_taken;
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
        is_taken.assign(neighbours[i].size() + 1, false);
        for (const int j : neighbours[i])
            if (colour[j] >= 0 && colour[j] < static_cast<int>(is_taken.size()))
                is_taken[colour[j]] = true;
        colour[i] = static_cast<int>(std::ranges::find(is_taken, false) - is_taken.begin());
    }
    return by_colours(colour);
}

Colouring colour_sets(std::span<const std::vector<int>> sets, int num_nodes) {
    return colour_greedily(neighbours_in(sets_of_nodes(sets, num_nodes), sets.size()));
}

Colouring colour_nodes(std::span<const std::vector<int>> sets, int num_nodes) {
    return colour_greedily(neighbours_in(sets, static_cast<std::size_t>(num_nodes)));
}

} // namespace livermark::interactive
