#include "fem_reference/node_order.hpp"

#include <algorithm>
#include <cstddef>

namespace livermark::fem_reference {

namespace {

/// The cells at each node.
struct CellsOfNodes {
    std::vector<int> start; ///< (n + 1)
    std::vector<int> cell;
};

CellsOfNodes cells_of_nodes(std::span<const int> cell_nodes, int nodes_per_cell, int num_nodes) {
    CellsOfNodes cells{std::vector<int>(num_nodes + 1, 0), std::vector<int>(cell_nodes.size())};
    for (const int node : cell_nodes)
        ++cells.start[node + 1];
    for (int node = 0; node < num_nodes; ++node)
        cells.start[node + 1] += cells.start[node];
    auto next = cells.start;
    for (std::size_t k = 0; k < cell_nodes.size(); ++k)
        cells.cell[next[cell_nodes[k]]++] = static_cast<int>(k) / nodes_per_cell;
    return cells;
}

} // namespace

std::vector<int> order_by_distance(std::span<const int> cell_nodes, int nodes_per_cell, int num_nodes) {
    const auto cells = cells_of_nodes(cell_nodes, nodes_per_cell, num_nodes);
    /// Appends a node and all that hang together with it, the nearest first.
    const auto append_around = [&](int start, std::vector<bool> &is_there, std::vector<int> &order) {
        is_there[start] = true;
        order.push_back(start);
        for (std::size_t next = order.size() - 1; next < order.size(); ++next)
            for (int k = cells.start[order[next]]; k < cells.start[order[next] + 1]; ++k)
                for (const int other : cell_nodes.subspan(cells.cell[k] * nodes_per_cell, nodes_per_cell))
                    if (!is_there[other]) {
                        is_there[other] = true;
                        order.push_back(other);
                    }
    };
    std::vector<int> order;
    std::vector<bool> is_there(num_nodes, false), was_seen(num_nodes, false);
    for (int node = 0; node < num_nodes; ++node) {
        if (is_there[node])
            continue;
        std::vector<int> part;
        append_around(node, was_seen, part);
        append_around(part.back(), is_there, order); // the farthest from an arbitrary one
    }
    return order;
}

} // namespace livermark::fem_reference
