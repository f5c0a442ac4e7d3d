#include "interactive/kernels/fans.hpp"

#include <algorithm>
#include <cstddef>
#include <queue>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"

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

} // namespace livermark::interactive::kernels
