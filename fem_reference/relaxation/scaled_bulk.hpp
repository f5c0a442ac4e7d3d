#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/discretisation.hpp"
#include "fem_reference/linear/mixed_solver.hpp"

namespace livermark::fem_reference {

/// The elements of a body whose shear moduli are those of the body and whose bulk moduli are multiplied by 1 / part: a
/// body whose shear moduli have fallen to a part of what they were, with all forces divided by that part. What is
/// mixed stays mixed, whatever Poisson's ratio becomes.
///
/// Where all regions have a pressure, the matrix of the displacements is that of the body, and so is its solver.
class ScaledBulk {
  public:
    /// @param body, matrices, solver  of each other; kept alive by the caller, body and matrices unchanged
    ScaledBulk(const core::Body &body, const Discretisation &matrices, ChosenSolver &solver, SolverChoice choice,
               double part);
    ScaledBulk(const ScaledBulk &) = delete;
    ScaledBulk &operator=(const ScaledBulk &) = delete;
    /// On a refined body, see StaticSolver.
    /// @param coarse  of the same part; kept alive by the caller
    ScaledBulk(const core::Body &body, const Discretisation &matrices, ChosenSolver &solver, SolverChoice choice,
               double part, ScaledBulk &coarse, double tolerance, std::span<const int> parent);

    /// Of the forces divided by the part.
    ConstrainedSolution solve(std::span<const double> prescribed, std::span<const double> load);

    /// What holds the body in a displacement, divided by the part.
    /// @param displacement  (3 n) [m]
    /// @return shape (3 n) [N]
    std::vector<double> force(std::span<const double> displacement);

    /// The displacements of the elements, without pressures.
    const ElasticSystem &system() const { return *system_; }

    /// Lets go of the factor of the matrix, if it has one of its own that no mixed solver works with.
    void forget_factor() {
        if (!mixed_)
            own_solver_.reset();
    }

  private:
    ChosenSolver &solver();

    SolverChoice choice_;
    ChosenSolver *body_solver_;
    const ElasticSystem *system_;
    std::unique_ptr<ElasticSystem> own_system_; ///< where some region has no pressure
    std::unique_ptr<ChosenSolver> own_solver_;
    PressureSystem pressure_;
    std::optional<MixedSolver> mixed_;
    std::optional<ConstrainedSolver> compliance_; ///< of the pressures, factored when it is first asked for
};

} // namespace livermark::fem_reference
