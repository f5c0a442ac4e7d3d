#pragma once

#include <vector>

#include "fem_reference/elastic_system.hpp"

namespace livermark::fem_reference {

/// The nodes of a system, neighbours near each other: by their distance from one that is far from most (the levels of
/// Cuthill and McKee 1969). A loop over rows in this order finds the entries of a vector that it needs in a cache.
/// @param matrix  of 3 x 3 blocks, as ElasticSystem has it
/// @return shape (n) the nodes in their new order
std::vector<int> order_by_distance(const SymmetricMatrix &matrix);

} // namespace livermark::fem_reference
