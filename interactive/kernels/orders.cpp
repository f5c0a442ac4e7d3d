#include "interactive/kernels/orders.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <queue>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"

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

namespace livermark::interactive::kernels {

namespace {

/// A tetrahedron as seen from one of its edges.
struct Opposite {
    int tetrahedron;
    std::array<int, 2> nodes; ///< that are not on the edge

    bool has(int node) const { return nodes[0] == node || nodes[1] == node; }
    int beside(int node) const { return nodes[0] == node ? nodes[1] : nodes[0]; }
};

using Opposites = std::vector<Opposite>;

std::vector<Opposites> around_edges(const std::vector<std::array<int, 4>> &tetrahedra, const core::EdgeTable &table) {
    std::vector<Opposites> around(table.edges.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (const int e : table.tetrahedron_edge[t]) {
            Opposite opposite{static_cast<int>(t), {}};
            std::size_t found = 0;
            for (const int node : tetrahedra[t])
                if (std::ranges::find(table.edges[e], node) == table.edges[e].end())
                    opposite.nodes[found++] = node;
            around[e].push_back(opposite);
        }
    return around;
}

/// As far as it goes from a tetrahedron, with a node of its rim first.
Fan walk(const Opposites &free, std::size_t start, int from) {
    Fan fan;
    fan.rim.push_back(from);
    std::vector<bool> is_used(free.size(), false);
    for (std::size_t at = start; at < free.size();) {
        is_used[at] = true;
        fan.tetrahedra.push_back(free[at].tetrahedron);
        fan.rim.push_back(free[at].beside(fan.rim.back()));
        at = 0;
        while (at < free.size() && (is_used[at] || !free[at].has(fan.rim.back())))
            ++at;
    }
    return fan;
}

Fan longest_fan(const Opposites &around, const std::vector<bool> &is_taken) {
    Opposites free;
    for (const auto &opposite : around)
        if (!is_taken[opposite.tetrahedron])
            free.push_back(opposite);
    Fan best;
    for (std::size_t start = 0; start < free.size() && best.tetrahedra.size() < free.size(); ++start)
        for (const int from : free[start].nodes)
            if (auto fan = walk(free, start, from); fan.tetrahedra.size() > best.tetrahedra.size())
                best = std::move(fan);
    return best;
}

} // namespace

std::vector<Fan> cut_into_fans(const std::vector<std::array<int, 4>> &tetrahedra) {
    const auto table = core::edge_table(tetrahedra);
    const auto around = around_edges(tetrahedra, table);
    std::vector<bool> is_taken(tetrahedra.size(), false);
    // Lengths as they were when an edge was looked at last; they only become less.
    std::priority_queue<std::pair<std::size_t, int>> edges;
    for (std::size_t e = 0; e < around.size(); ++e)
        edges.emplace(around[e].size(), -static_cast<int>(e));
    std::vector<Fan> fans;
    while (!edges.empty()) {
        const auto [length, minus_edge] = edges.top();
        edges.pop();
        auto fan = longest_fan(around[-minus_edge], is_taken);
        if (fan.tetrahedra.empty())
            continue;
        edges.emplace(fan.tetrahedra.size(), minus_edge);
        if (fan.tetrahedra.size() < length)
            continue;
        for (const int t : fan.tetrahedra)
            is_taken[t] = true;
        fan.axis = table.edges[-minus_edge];
        fans.push_back(std::move(fan));
    }
    return fans;
}

namespace {

using Triangles = std::vector<std::array<int, 3>>;

bool has_node(const std::array<int, 3> &triangle, int node) {
    return std::ranges::find(triangle, node) != triangle.end();
}

/// Triangles that share an edge with each.
std::vector<std::vector<int>> edge_neighbours(const Triangles &triangles) {
    std::vector<std::vector<int>> neighbours(triangles.size());
    for (std::size_t s = 0; s < triangles.size(); ++s)
        for (std::size_t t = 0; t < triangles.size(); ++t)
            if (s != t && std::ranges::count_if(triangles[s], [&](int n) { return has_node(triangles[t], n); }) == 2)
                neighbours[s].push_back(static_cast<int>(t));
    return neighbours;
}

class StripWalk {
  public:
    explicit StripWalk(const std::vector<std::vector<int>> &neighbours)
        : neighbours_(&neighbours), is_taken_(neighbours.size(), false) {}

    /// @return triangles, strip after strip
    std::vector<std::vector<int>> from(int first) {
        std::vector<std::vector<int>> strips;
        for (int start = first; start >= 0; start = loneliest_of_all()) {
            auto &strip = strips.emplace_back();
            for (int at = start; at >= 0; at = loneliest((*neighbours_)[at])) {
                is_taken_[at] = true;
                strip.push_back(at);
            }
        }
        return strips;
    }

  private:
    int num_free_neighbours(int triangle) const {
        return static_cast<int>(std::ranges::count_if((*neighbours_)[triangle], [&](int t) { return !is_taken_[t]; }));
    }

    /// The one that is left with the fewest neighbours, so that none is left alone; -1 if all are taken.
    int loneliest(const std::vector<int> &triangles) const {
        int best = -1, fewest = 4;
        for (const int t : triangles)
            if (!is_taken_[t] && num_free_neighbours(t) < fewest) {
                best = t;
                fewest = num_free_neighbours(t);
            }
        return best;
    }

    int loneliest_of_all() const {
        std::vector<int> all(neighbours_->size());
        for (std::size_t t = 0; t < all.size(); ++t)
            all[t] = static_cast<int>(t);
        return loneliest(all);
    }

    const std::vector<std::vector<int>> *neighbours_;
    std::vector<bool> is_taken_;
};

/// The nodes of a strip; those of its first triangle in an order that lets the second one follow.
void append_strip(const Triangles &triangles, const std::vector<int> &strip, std::vector<StripNode> &nodes) {
    auto first = triangles[strip[0]];
    if (strip.size() > 1) { // the node that the second one does not have comes first
        const auto alone = std::ranges::find_if(first, [&](int node) { return !has_node(triangles[strip[1]], node); });
        std::rotate(first.begin(), alone, first.end());
    }
    for (const int node : first)
        nodes.push_back({node, -1, false});
    nodes.back().triangle = strip[0];
    int a = first[0], b = first[1], c = first[2];
    for (std::size_t k = 1; k < strip.size(); ++k) {
        const auto &next = triangles[strip[k]];
        const bool keeps_first = has_node(next, a);
        if (!keeps_first)
            a = b;
        b = c;
        c = *std::ranges::find_if(next, [&](int node) { return node != a && node != b; });
        nodes.push_back({c, strip[k], keeps_first});
    }
}

} // namespace

std::vector<StripNode> cut_into_strips(const std::vector<std::array<int, 3>> &triangles) {
    const auto neighbours = edge_neighbours(triangles);
    std::vector<std::vector<int>> best;
    for (std::size_t first = 0; first < triangles.size() && best.size() != 1; ++first) {
        auto strips = StripWalk(neighbours).from(static_cast<int>(first));
        if (best.empty() || strips.size() < best.size())
            best = std::move(strips);
    }
    std::vector<StripNode> nodes;
    for (const auto &strip : best)
        append_strip(triangles, strip, nodes);
    return nodes;
}

} // namespace livermark::interactive::kernels
