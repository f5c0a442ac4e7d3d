#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "interactive/elements/point_springs.hpp"
#include "interactive/kernels/node_rows.hpp"

namespace livermark::interactive::kernels {

/// Springs of as many nodes each, 16 side by side, filled up with springs of no stiffness.
struct PointSpringSet {
    std::size_t num_nodes = 0;
    Aligned<std::int32_t> corner; ///< num_nodes vectors of 16 for each batch: four times the row of a node
    Aligned<std::int32_t> slot;   ///< as corner: four times the slot of the force
    Aligned<float> numbers;       ///< of each batch num_numbers() vectors of 16: weights, d at rest, l, k

    std::size_t num_numbers() const { return num_nodes + 5; }
    std::size_t num_batches() const { return corner.size() / (num_nodes * slice_size); }
};

/// Springs beside elements for vector units, in single precision. Each puts the forces on its nodes into slots of its
/// own, and a node sums its slots, always in the same order.
struct PointSpringRows {
    std::vector<PointSpringSet> sets;
    std::vector<std::size_t> slot_start; ///< (rows / 4 + 1) in units of four slots: the k-th of four nodes side by side
    Aligned<float> force;                ///< in slots; zero where nothing writes, and one more for what fills up

    std::size_t bytes() const;
};

/// @param nodes  of the scene
PointSpringRows point_spring_rows(const Scene &scene, std::span<const PointSpring> springs, const NodeRows &nodes);

} // namespace livermark::interactive::kernels
