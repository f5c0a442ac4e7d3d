#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/problem.hpp"

namespace livermark::benchmarks {

/// The same body with its nodes in another order.
/// @param order  shape (N), the old number of each new node
core::Body renumbered(core::Body body, std::span<const int> order);

/// The neighbours of each node, one node after the other, with the nodes in reverse Cuthill-McKee order: what a kernel
/// fetches that computes all springs of a node together. Every spring stands at both of its ends.
struct Neighbours {
    std::vector<int> start;     ///< (N + 1) index into neighbour
    std::vector<int> neighbour; ///< (2 S) node numbers in that order

    int num_nodes() const { return static_cast<int>(start.size()) - 1; }
    int num_springs() const { return static_cast<int>(neighbour.size()) / 2; }
};

Neighbours neighbours(std::span<const std::array<int, 2>> edges, int num_nodes);

} // namespace livermark::benchmarks
