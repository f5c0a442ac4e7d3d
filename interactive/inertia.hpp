#pragma once

#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// What backward Euler minimises beside the elastic energy, as a spring of each node to where it would go without it:
///     sum over the nodes of m (1 + alpha h) / (2 h^2) |x - y|^2,
///     y = x_n + (h v_n + h^2 f_ext / m) / (1 + alpha h),
/// with the new velocity v = (x - x_n) / h. Where the sum with W is least,
///     m (v - v_n) = h (f_ext - dW/dx - alpha m v).
struct Inertia {
    std::vector<double> stiffness; ///< (N) m (1 + alpha h) / h^2 [N/m]
    Field predicted;               ///< y, and the target where constrained, shape (3, N) [m]
};

/// @param time_step  h [s], > 0
Inertia inertia(const Simulation &simulation, double time_step);

} // namespace livermark::interactive
