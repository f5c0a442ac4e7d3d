#pragma once

#include <memory>
#include <span>

#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/preconditioner.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"

namespace livermark::fem_reference {

/// K u = f with some unknowns prescribed, by preconditioned conjugate gradients.
class IterativeSolver {
  public:
    /// Norm of the residual over that of the right-hand side of the free rows at which the iteration stops.
    static constexpr double tolerance = 1e-11;

    /// @param stiffness       symmetric positive semidefinite; kept alive and unchanged by the caller
    /// @param preconditioner  of this matrix
    /// @param max_iterations  after how many steps it gives up
    IterativeSolver(const SymmetricBlocks<double> &stiffness, std::unique_ptr<Preconditioner> preconditioner,
                    int max_iterations = 2000);

    /// Prepares the preconditioner, unless the same unknowns were prescribed last time.
    /// @param prescribed  shape (n), NaN where an unknown is free
    /// @return whether the conditions fix the solution
    bool set_up(std::span<const double> prescribed);

    /// Where iterations begin and end.
    struct Aim {
        std::span<const double> guess{}; ///< (n) of the solution; empty for zero
        double relative_residual = tolerance;
    };

    /// Sets up if need be, and solves. A solution that has not converged says so and is the last iterate.
    /// @param prescribed  shape (n), NaN where an unknown is free
    /// @param load        shape (n), loads on prescribed unknowns count in the residual
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load, const Aim &aim);
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load) {
        return solve(prescribed, load, Aim{});
    }

    Preconditioner &preconditioner() const { return *preconditioner_; }

    /// Seconds that the preconditioner in use took, also when it was made for an earlier solve.
    double setup_seconds() const { return setup_seconds_; }

  private:
    struct Ending {
        int iterations = 0;
        double relative_residual = 0.0;
    };
    /// u += K^-1 residual on the free unknowns that the preconditioner is set up for.
    /// @param residual  shape (n), zero where not free, used up
    /// @param constrained      entries that are not free, see constrained_entries()
    /// @param size      norm of the right-hand side
    /// @param goal      norm of the residual over that at which it stops
    Ending add_solution(std::span<double> residual, std::span<double> u, std::span<const std::size_t> constrained,
                        double size, double goal);

    const SymmetricBlocks<double> &stiffness_;
    std::unique_ptr<Preconditioner> preconditioner_;
    int max_iterations_;
    FreeUnknowns free_;
    double setup_seconds_ = 0.0;
};

} // namespace livermark::fem_reference
