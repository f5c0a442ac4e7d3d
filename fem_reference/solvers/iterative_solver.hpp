#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

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

    /// Begin and end of iterations.
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

/// A sparse matrix in compressed rows that need not be square.
struct SparseRows {
    std::vector<int> row_start; ///< (m + 1) index into column and value
    std::vector<int> column;    ///< (nonzeros)
    std::vector<double> value;  ///< (nonzeros)
};

/// Displacements and pressures of a body as those of the refined one: iterations there begin at the solution on
/// the mesh before refinement, which is wrong by percents where zero is wrong by all.
struct NestedIteration {
    Prolongation displacement;
    SparseRows pressure; ///< (m_fine, m_coarse)

    /// p_c = P p_coarse,c
    /// @param coarse  shape (m_coarse, lanes), see matrices.hpp
    /// @return shape (m_fine, lanes)
    std::vector<double> prolonged_pressure(std::span<const double> coarse, int lanes) const;
};

/// @param coarse, fine                    systems of degree 2 of a body and of one that is refined
/// @param coarse_pressure, fine_pressure  assembled on them
/// @param parent                          see prolongation()
/// @throws std::invalid_argument if the fine system is not that of the refined body
NestedIteration nested_iteration(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 std::span<const int> parent = {});

} // namespace livermark::fem_reference
