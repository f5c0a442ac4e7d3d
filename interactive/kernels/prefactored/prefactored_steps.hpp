#pragma once

#include <functional>
#include <variant>
#include <vector>

#include "interactive/kernels/explicit_rows.hpp"
#include "interactive/kernels/prefactored/factor_rows.hpp"
#include "interactive/kernels/prefactored/spring_rows.hpp"

namespace livermark::interactive::kernels {

/// Tetrahedra of densities::Projective, or springs.
using PrefactoredElements = std::variant<ExplicitRows, SpringRows>;

/// A body of Prefactored, its state, and its factor for one time step.
struct PrefactoredRows {
    explicit PrefactoredRows(PrefactoredElements of_body);

    NodeRows &nodes();
    const NodeRows &nodes() const;
    std::size_t bytes() const; ///< of the body, its state and the factor
    Orders orders() const;     ///< of the body

    /// @param unknown    (N) of each node, -1 where constrained
    /// @param stiffness  (N) m (1 + alpha h) / h^2 [N/m]
    void set_factor(const support::SupernodalFactor &of_matrix, const std::vector<int> &unknown,
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
