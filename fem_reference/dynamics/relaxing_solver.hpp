#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
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

    /// Forces that hold the body in a displacement, divided by the part.
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

/// Linear elasticity whose deviatoric stress relaxes by one Prony series in all regions, on the elements of a
/// StaticSolver: quasi-static, masses do not matter.
///
/// By the correspondence principle (Christensen, Theory of Viscoelasticity, 1982, ch. 2) the Laplace transform of its
/// solution is the elastic solution u(a) with shear moduli multiplied by a = s G(s) / G(0), which for s > 0 is between
/// remaining() and 1. u(a) is analytic there, so few elastic solutions span the motion at all times: at a = 1 and a =
/// remaining(), and at values between until a new one is in the space of those before. The body is put on that space by
/// Galerkin's method, which keeps energies and dissipation what they are in a body, and followed there in time by the
/// exact exponential update of Taylor. The solution at a time costs nothing then, and elastic solvers do all the work.
class RelaxingSolver {
  public:
    /// New part of an elastic solution, over the first one, in the norm of the energy, when there are enough.
    static constexpr double enough = 1e-6;
    static constexpr int most_solutions = 9;

    /// @param body, elements  of each other; kept alive by the caller
    RelaxingSolver(std::shared_ptr<const core::Body> body, StaticSolver &elements, SolverChoice choice);
    /// On a refined body, by iterations that begin at solutions on the body itself.
    /// @param elements, coarse  kept alive by the caller; the elements were made from those of the coarse one
    /// @param tolerance, parent  see StaticSolver
    RelaxingSolver(std::shared_ptr<const core::Body> body, StaticSolver &elements, SolverChoice choice,
                   RelaxingSolver &coarse, double tolerance, std::span<const int> parent);
    ~RelaxingSolver();
    RelaxingSolver(RelaxingSolver &&) noexcept;
    RelaxingSolver &operator=(RelaxingSolver &&) noexcept;

    /// @param load_case         with a slow history; with a release too, it ends at the whole load
    /// @param steps_per_record  see follow()
    /// @return a PathPoint for each time, with work and dissipated energy; the other fields are those of
    ///   SlowHistory::whole_load_record(). With a release the motion after it, see release_relaxed(), but not of mixed
    ///   elements. Status not_converged as of StaticSolver::solve().
    core::Solution solve(const core::LoadCase &load_case, int steps_per_record = 8);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
