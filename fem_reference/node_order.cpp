#include "fem_reference/node_order.hpp"

namespace livermark::fem_reference {

namespace {

/// Appends a node and all that hang together with it, the nearest first.
void append_around(const SymmetricMatrix &matrix, int start, std::vector<bool> &is_there, std::vector<int> &order) {
    is_there[start] = true;
    order.push_back(start);
    for (std::size_t next = order.size() - 1; next < order.size(); ++next) {
        const int row = 3 * order[next];
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; k += 3)
            if (const int other = matrix.column[k] / 3; !is_there[other]) {
                is_there[other] = true;
                order.push_back(other);
            }
    }
}

} // namespace

std::vector<int> order_by_distance(const SymmetricMatrix &matrix) {
    const int num_nodes = matrix.num_rows() / 3;
    std::vector<int> order;
    std::vector<bool> is_there(num_nodes, false), was_seen(num_nodes, false);
    for (int node = 0; node < num_nodes; ++node) {
        if (is_there[node])
            continue;
        std::vector<int> part;
        append_around(matrix, node, was_seen, part);
        append_around(matrix, part.back(), is_there, order); // the farthest from an arbitrary one
    }
    return order;
}

} // namespace livermark::fem_reference
