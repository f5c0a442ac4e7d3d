#pragma once

#include <cstdint>
#include <functional>
#include <variant>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/explicit_steps.hpp"

namespace livermark::interactive::kernels {

/// The columns of a supernode of L, the triangle L11 on top and the rectangle L21 below it, as the panel
///     B = [L11^-1; -L21 L11^-1],
/// by which both sweeps are products that wait for nothing: forwards (x1, x2) <- B x1 + (0, x2), backwards
/// x1 <- B^T (x1, x2).
struct Panel {
    std::size_t first_column, num_columns; ///< of L
    std::size_t first_block, num_blocks;   ///< of 16 rows, the last one filled up
    std::size_t first_value;

    /// Columns that share a load.
    static constexpr std::size_t columns_at_once = 4;
    std::size_t stored_columns() const {
        return (num_columns + columns_at_once - 1) / columns_at_once * columns_at_once;
    }
    /// Rows of the triangle have no more than these.
    std::size_t columns_of_block(std::size_t block) const {
        return std::min(stored_columns(), (block + 1) * slice_size);
    }
};

/// A factor of P A P^T = L L^T in single precision for vector units, which solves for three right-hand sides at once:
/// x, y and z stand side by side in a row of four, and an entry is read once for all of them.
struct FactorRows {
    std::size_t num_unknowns = 0;
    std::vector<std::int32_t> place; ///< (n) four times the place of each unknown in the order of L
    std::vector<Panel> panels;
    Aligned<std::int32_t> row;   ///< 16 for each block: four times the place; the one behind all others fills up
    Aligned<float> values;       ///< block after block, and in each column after column
    Aligned<float> x;            ///< (n + 1) rows of four: right-hand sides, and the solutions; zero behind all others
    Aligned<float> own, fetched; ///< space for the columns and the rows of a panel

    std::size_t bytes() const { return bytes_of(row, values, x); }
};

FactorRows factor_rows(const support::SupernodalFactor &factor);

/// Numbers of a spring at one of its nodes: from there to the other one at rest, length at rest, stiffness.
inline constexpr std::size_t numbers_of_spring = 5;

/// Springs at nodes for vector units, in single precision. 16 nodes stand side by side, and each spring stands at both
/// of its nodes: so nodes sum their own forces, and nothing is scattered. They are filled up with springs of no
/// stiffness.
struct SpringRows : NodeRows {
    std::vector<std::size_t> item_start; ///< (rows / 16 + 1) in units of 16: the k-th spring of nodes side by side
    Aligned<std::int32_t> other;         ///< four times the row of the other node
    Aligned<float> numbers;              ///< numbers_of_spring vectors of 16 for each
    Aligned<std::int32_t> self;          ///< (rows) four times the row
    Aligned<float> force;                ///< rows of four [N]

    std::size_t bytes() const { return NodeRows::bytes() + bytes_of(item_start, other, numbers, self, force); }
};

SpringRows spring_rows(const Scene &scene, const Springs &springs);

/// Tetrahedra of densities::Projective, or springs.
using PrefactoredElements = std::variant<ExplicitRows, SpringRows>;

/// A body of Prefactored, its state, and its factor for one time step.
struct PrefactoredRows {
    explicit PrefactoredRows(PrefactoredElements body);

    NodeRows &nodes() {
        return std::visit([](auto &body) -> NodeRows & { return body; }, elements);
    }
    const NodeRows &nodes() const;
    std::size_t bytes() const; ///< of the body, its state and the factor
    Orders orders() const;     ///< of the body

    /// @param unknown    (N) of each node, -1 where constrained
    /// @param stiffness  (N) m (1 + alpha h) / h^2 [N/m]
    void set_factor(const support::SupernodalFactor &matrix, const std::vector<int> &unknown,
                    const std::vector<double> &stiffness);

    PrefactoredElements elements;
    FactorRows factor;
    /// (rows) where the row of a node is in the factor's x; behind all where it is not
    std::vector<std::int32_t> place;
    // Rows of four.
    Aligned<float> before;                 ///< displacement when a step began [m]
    Aligned<float> predicted;              ///< where nodes would be without elasticity [m]
    Aligned<float> stiffness;              ///< of inertia [N/m]
    Aligned<float> right;                  ///< right-hand sides [N]
    std::function<void()> after_iteration; ///< what else moves nodes; empty if there is nothing
};

/// A step as Prefactored takes it, in single precision on the vectors of the machine. Constrained nodes keep their
/// velocities.
/// @param time_step     h [s], that of the factor
/// @param mass_damping  alpha [1/s]
void take_prefactored_step(PrefactoredRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
