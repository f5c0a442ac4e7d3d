#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

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

    /// Sentence on the solver and its iterations, for the result file.
    std::string description(const ConstrainedSolution &solution) const;

  private:
    const SymmetricBlocks<double> *stiffness_;
    mutable std::unique_ptr<SymmetricBlocks<float>> single_precision_; ///< of two levels, or when it is first asked for
    std::optional<ConstrainedSolver> direct_;
    std::unique_ptr<Preconditioner> factor_; ///< a view of direct_
    std::optional<IterativeSolver> iterative_;
};

/// Linear elements on the same body, whose solver is the coarse one of iterations on quadratic elements: of the mixed
/// formulation, which needs only an approximate inverse of K, and of large bodies in displacements alone. The factor of
/// quadratic elements fills most of the memory and takes most of the time, and so would that of the linear ones of a
/// very large body, which multigrid solves. Empty where the user chose a solver.
struct Corners {
    Corners() = default;
    /// @param largest_factor  unknowns of linear elements beyond which there is multigrid
    /// @param foundation      that the body stands on
    Corners(const core::Body &body, SolverChoice choice, const Discretisation &matrices,
            int largest_factor = largest_direct_coarse_system, const std::optional<core::Foundation> &foundation = {});

    std::unique_ptr<ElasticSystem> system;
    std::unique_ptr<ChosenSolver> solver;
};

/// [K D^T; D -C] [u; p] = [f; 0] with some displacements prescribed, by iterations on both at once, see
/// chosen_solver.cpp. With these elements the number of iterations depends neither on the mesh nor on Poisson's ratio.
/// At last all that is free moves by a rigid motion, so that the reactions balance the loads whatever the tolerance,
/// see balance().
class MixedSolver {
  public:
    /// Residual that is left, over the first, as the preconditioner sees them.
    static constexpr double default_tolerance = 1e-9;
    static constexpr int max_iterations = 1000;

    /// @param system  of K; it, its solver and the pressure are kept alive by the caller, system and pressure unchanged
    MixedSolver(const ElasticSystem &system, ChosenSolver &solver, const PressureSystem &pressure,
                double tolerance = default_tolerance);
    /// On a refined body: iterations begin at a solution of the solver on the body itself.
    /// @param coarse  kept alive by the caller; what it is set up for changes
    MixedSolver(const ElasticSystem &system, ChosenSolver &solver, const PressureSystem &pressure, double tolerance,
                MixedSolver &coarse, NestedIteration nested);
    ~MixedSolver();
    MixedSolver(MixedSolver &&) noexcept;
    MixedSolver &operator=(MixedSolver &&) noexcept;

    /// Sets up the solver of K if need be, and solves. Several are solved as one system, so that matrices come from
    /// memory once for all; each is within the tolerance.
    /// @param conditions  at least one, at most max_columns()
    /// @return of each: residual K u + D^T p - f; energy 1/2 (u^T K u + p^T C p). Unless all are unique, none is solved
    std::vector<ConstrainedSolution> solve(std::span<const Conditions> conditions);

    /// One column.
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load);

    /// Number that take less time together than one by one.
    std::size_t max_columns() const;

    /// Sentence on the solver and its iterations, for the result file.
    std::string description(const ConstrainedSolution &solution) const;

  private:
    struct Impl;
    struct State;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
