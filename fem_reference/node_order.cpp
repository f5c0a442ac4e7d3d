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

std::size_t num_blocks_below(const SymmetricMatrix &matrix) {
    return (matrix.column.size() / 9 - static_cast<std::size_t>(matrix.num_rows() / 3)) / 2;
}

LowerRows lower_rows(const SymmetricMatrix &matrix, const std::function<void(int, int, const double *, int)> &take) {
    LowerRows rows{order_by_distance(matrix), {0}, {}};
    std::vector<int> place(rows.node.size());
    for (std::size_t at = 0; at < rows.node.size(); ++at)
        place[rows.node[at]] = static_cast<int>(at);
    rows.column.reserve(num_blocks_below(matrix));
    for (const int node : rows.node) {
        const int begin = matrix.row_start[3 * node];
        const int length = matrix.row_start[3 * node + 1] - begin;
        for (int k = 0; k < length; k += 3) {
            const int other = matrix.column[begin + k] / 3;
            if (place[other] > place[node])
                continue;
            take(node, other, &matrix.value[begin + k], length);
            if (other != node)
                rows.column.push_back(place[other]);
        }
        rows.row_start.push_back(static_cast<int>(rows.column.size()));
    }
    return rows;
}

} // namespace livermark::fem_reference
