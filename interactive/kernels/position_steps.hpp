#pragma once

#include <cstdint>
#include <functional>

#include "interactive/kernels/node_rows.hpp"

namespace livermark::interactive::kernels {

/// Kinds of constraints, and the numbers that each has. Gradients are those of the shape functions of the second,
/// third and fourth node of a tetrahedron.
enum class Constraint : std::uint8_t {
    distance, ///< |x_a - x_b| - l: x_a - x_b at rest, l, compliance [m/N]
    volume,   ///< J - 1: 9 of gradients, compliance [1/J]
    pair      ///< |F| and J - 1 - mu / k: 9 of gradients, mu / k, both compliances [1/J]
};

constexpr std::size_t num_nodes_of(Constraint kind) {
    return kind == Constraint::distance ? 2 : 4;
}
constexpr std::size_t num_numbers_of(Constraint kind) {
    return kind == Constraint::distance ? 5 : kind == Constraint::volume ? 10 : 12;
}
constexpr std::size_t num_multipliers_of(Constraint kind) {
    return kind == Constraint::pair ? 2 : 1;
}

/// Constraints of one kind, colour after colour, 16 of one colour in a batch: no two of a batch share a node, so it
/// moves them at once. Batches are filled up with constraints of nodes that cannot move.
struct ConstraintRows {
    Constraint kind = Constraint::distance;
    Aligned<std::int32_t> corner; ///< vectors of 16 for each batch: four times the node
    Aligned<float> numbers, multipliers;
    std::vector<std::size_t>
        place; ///< (M) of each constraint in its order of colours: 16 times the batch plus the lane

    std::size_t num_batches() const { return corner.size() / (num_nodes_of(kind) * slice_size); }
};

/// Nodes in their order, and one more row that cannot move. The last number of a displacement is the inverse mass that
/// a step has [1/kg], that of an inverse mass is zero.
struct PositionRows : NodeRows {
    explicit PositionRows(const Scene &scene);

    Aligned<float> before; ///< displacement when the step began
    float damping = 0.0F;  ///< 1 + alpha h of the inverse masses in displacement; 0 if there are none yet
    std::vector<ConstraintRows> sets;
    std::function<void()> after_iteration; ///< what else moves nodes, after all sets; empty if there is nothing

    std::size_t bytes() const; ///< of the body and its state
};

/// @param offsets  where each colour begins, and the end
/// @param nodes    of each in the order of colours, num_nodes_of() behind each other
/// @param numbers  of each as the kind has them, num_numbers_of() behind each other
ConstraintRows constraint_rows(Constraint kind, const std::vector<int> &offsets, const std::vector<int> &nodes,
                               const std::vector<double> &numbers, int num_nodes);

/// A step as PositionBased takes it, in single precision on the vectors of the machine: each iteration visits the sets
/// in their order and the batches of each in theirs. Constrained nodes keep their velocities.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
void take_position_step(PositionRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
