#pragma once

#include <functional>
#include <vector>

#include "fem_reference/elastic_system.hpp"

namespace livermark::fem_reference {

/// The nodes of a system, neighbours near each other: by their distance from one that is far from most (the levels of
/// Cuthill and McKee 1969). A loop over rows in this order finds the entries of a vector that it needs in a cache.
/// @param matrix  of 3 x 3 blocks, as ElasticSystem has it
/// @return shape (n) the nodes in their new order
std::vector<int> order_by_distance(const SymmetricMatrix &matrix);

/// Where the 3 x 3 blocks below the diagonal stand when the nodes are in that order.
struct LowerRows {
    std::vector<int> node;      ///< (n) at each place of the order
    std::vector<int> row_start; ///< (n + 1) of the blocks below the diagonal
    std::vector<int> column;    ///< (blocks) place
};

std::size_t num_blocks_below(const SymmetricMatrix &matrix);

/// @param take  called for every block on and below the diagonal, row by row: with its two nodes, where its first value
///   is, and how many values further its next row begins
LowerRows lower_rows(const SymmetricMatrix &matrix,
                     const std::function<void(int node, int other, const double *first, int stride)> &take);

} // namespace livermark::fem_reference
