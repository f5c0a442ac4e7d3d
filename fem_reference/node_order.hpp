#pragma once

#include <span>
#include <vector>

#include "fem_reference/elastic_system.hpp"

namespace livermark::fem_reference {

/// The nodes of cells, neighbours near each other: by their distance from one that is far from most (the levels of
/// Cuthill and McKee 1969). A loop over rows in this order finds the entries of a vector that it needs in a cache.
/// @param cell_nodes  (M, nodes_per_cell)
/// @param num_nodes   all in some cell
/// @return shape (n) the nodes in their new order
std::vector<int> order_by_distance(std::span<const int> cell_nodes, int nodes_per_cell, int num_nodes);

/// Where the 3 x 3 blocks below the diagonal stand.
struct LowerRows {
    std::vector<int> row_start; ///< (n + 1)
    std::vector<int> column;    ///< (blocks)
    std::size_t num_nodes() const { return row_start.size() - 1; }
};

/// @param matrix  of 3 x 3 blocks, as ElasticSystem has it
LowerRows lower_rows(const SymmetricMatrix &matrix);

/// Where the first number of each block on and below the diagonal stands, row by row, the diagonal last.
/// @param take  called with its row, its column, that place, and how many numbers further its next row begins
template <class Take> void for_each_lower_block(const SymmetricMatrix &matrix, const Take &take) {
    for (int node = 0; 3 * node < matrix.num_rows(); ++node) {
        const int begin = matrix.row_start[3 * node];
        const int length = matrix.row_start[3 * node + 1] - begin;
        for (int k = 0; k < length && matrix.column[begin + k] <= 3 * node; k += 3)
            take(node, matrix.column[begin + k] / 3, &matrix.value[begin + k], length);
    }
}

} // namespace livermark::fem_reference
