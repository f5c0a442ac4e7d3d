#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/problem.hpp"
#include "fem_reference/linear/choices.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/iterative_solver.hpp"

namespace livermark::fem_reference {

/// K u = f with some unknowns prescribed, by the solver that was chosen.
class ChosenSolver {
  public:
    /// @param system  kept alive and unchanged by the caller
    ChosenSolver(const ElasticSystem &system, SolverChoice choice);

    /// Conjugate gradients on two levels, see two_level().
    /// @param fine, coarse, coarse_solver  kept alive by the caller, the systems unchanged
    /// @param parent                       see prolongation()
    ChosenSolver(const ElasticSystem &fine, const ElasticSystem &coarse, ChosenSolver &coarse_solver,
                 std::span<const int> parent = {});

    /// Factors or prepares, unless the same unknowns were prescribed last time.
    /// @param prescribed  shape (n), NaN where an unknown is free
    void set_up(std::span<const double> prescribed);

    /// Sets up if need be, and solves.
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load);

    /// Seconds that the set-up in use took, also when it was made for an earlier solve.
    double setup_seconds() const;

    /// out_c = K x_c, whatever is prescribed
    /// @param x, out  shape (n, lanes), not the same
    void multiply(std::span<const double> x, std::span<double> out) const;
    /// The same in single precision.
    void multiply(std::span<const float> x, std::span<float> out) const;

    /// An approximate inverse of the matrix: the factor, or the preconditioner of the iterative solver.
    Preconditioner &inverse();

    /// Number of right-hand sides that take less time together than one by one.
    std::size_t max_columns() const;

    /// The sparse Cholesky factor, nullptr where there are iterations.
    ConstrainedSolver *direct() { return direct_ ? &*direct_ : nullptr; }

    /// For the result file.
    std::string description(const ConstrainedSolution &solution) const;

  private:
    const SymmetricBlocks<double> *stiffness_;
    mutable std::unique_ptr<SymmetricBlocks<float>> single_precision_; ///< of two levels, or when it is first asked for
    std::optional<ConstrainedSolver> direct_;
    std::unique_ptr<Preconditioner> factor_; ///< a view of direct_
    std::optional<IterativeSolver> iterative_;
};

/// The matrices of one body.
struct Discretisation {
    /// @throws std::invalid_argument for the mixed formulation of linear elements, or as assemble() does
    Discretisation(const core::Body &body, int degree, Formulation formulation);

    ElasticSystem system;
    PressureSystem pressure; ///< empty where nothing is nearly incompressible
};

/// Linear elements on the same body, whose solver is the coarse one of iterations on quadratic elements: of the mixed
/// formulation, which needs only an approximate inverse of K, and of large bodies in displacements alone. The factor of
/// quadratic elements fills most of the memory and takes most of the time, and so would that of the linear ones of a
/// very large body, which multigrid solves. Empty where the user chose a solver.
struct Corners {
    Corners() = default;
    /// @param largest_factor  unknowns of linear elements beyond which there is multigrid
    Corners(const core::Body &body, SolverChoice choice, const Discretisation &matrices,
            int largest_factor = largest_direct_coarse_system);

    std::unique_ptr<ElasticSystem> system;
    std::unique_ptr<ChosenSolver> solver;
};

} // namespace livermark::fem_reference
