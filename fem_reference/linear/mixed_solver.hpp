#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/iterative_solver.hpp"

namespace livermark::fem_reference {

/// [K D^T; D -C] [u; p] = [f; 0] with some displacements prescribed, by iterations on both at once, see
/// mixed_solver.cpp. With these elements the number of iterations depends neither on the mesh nor on Poisson's ratio.
/// At last all that is free moves by a rigid motion, so that the reactions balance the loads whatever the tolerance,
/// see balance().
class MixedSolver {
  public:
    /// Of what is left, over the first, as the preconditioner sees them.
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

    /// Of one.
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load);

    /// Number that take less time together than one by one.
    std::size_t max_columns() const;

    /// For the result file.
    std::string description(const ConstrainedSolution &solution) const;

  private:
    struct Impl;
    struct State;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
