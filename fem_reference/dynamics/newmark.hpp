#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// Where all unknowns are and how they move; n is the number of nodes.
struct Motion {
    std::vector<double> displacement; ///< (3 n) u [m]
    std::vector<double> velocity;     ///< (3 n) v [m/s]
};

/// Energies of a motion.
struct Energy {
    double kinetic = 0.0; ///< 1/2 v^T M v [J]
    double strain = 0.0;  ///< 1/2 u^T K u [J]
};

/// Newmark's average acceleration (gamma = 1/2, beta = 1/4) for M u'' + D u' + K u = f with Rayleigh damping,
/// consistent mass and loads that do not change. With v_m the mean of the velocities before and after a step of length
/// h, it is
///     (2 M / h + D + h K / 2) v_m = 2 M v / h + f - K u,   u <- u + h v_m,   v <- 2 v_m - v,
/// which needs no accelerations and one solve. It is of second order, stable for every h, and without damping conserves
/// 1/2 v^T M v + 1/2 u^T K u - f^T u.
/// (N. M. Newmark 1959, A method of computation for structural dynamics, J. Eng. Mech. Div. 85(3))
///
/// The matrix on the left is factored once.
class Newmark {
  public:
    /// @param stiffness   shape (3 n, 3 n) [N/m]; the caller keeps it alive and unchanged
    /// @param mass        shape (n, n) [kg], of one component, as consistent_mass gives it; kept alive as well
    /// @param damping     alpha and beta not negative
    /// @param time_step   h [s], > 0
    /// @param prescribed  shape (3 n), NaN where an unknown is free; the others stay where the motion starts
    /// @throws std::runtime_error if the memory does not hold the factor
    Newmark(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass, const core::RayleighDamping &damping,
            double time_step, std::span<const double> prescribed);
    ~Newmark();
    Newmark(Newmark &&) noexcept;
    Newmark &operator=(Newmark &&) noexcept;

    /// Moves on by one step.
    /// @param motion  velocity zero where prescribed
    /// @param load    f, shape (3 n) [N]
    /// @return the energies before the step, which are a by-product of it
    Energy advance(Motion &motion, std::span<const double> load);

    Energy energy(const Motion &motion) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
