#pragma once

#include <span>
#include <vector>

namespace livermark::fem_reference {

/// How the nodes of a system are numbered.
enum class NodeOrder {
    of_mesh,    ///< the first N are those of the mesh, in its numbering; with quadratic elements edge midpoints follow
    by_distance ///< neighbours near each other, see order_by_distance(): for iterations, which live from the caches
};

/// The nodes of cells, neighbours near each other: by their distance from one that is far from most (the levels of
/// Cuthill and McKee 1969). A loop over rows in this order finds the entries of a vector that it needs in a cache.
/// @param cell_nodes  (M, nodes_per_cell)
/// @param num_nodes   all in some cell
/// @return shape (n) the nodes in their new order
std::vector<int> order_by_distance(std::span<const int> cell_nodes, int nodes_per_cell, int num_nodes);

} // namespace livermark::fem_reference
