#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"

namespace livermark::fem_reference {

/// State of a body that relaxes, with the memory of its branches.
struct RelaxedState {
    std::vector<double> displacement;          ///< (3 n) u [m]
    std::vector<std::vector<double>> branches; ///< (B) of (3 n) w_k [m], of which each branch bears D w_k
};

/// The volumetric and the deviatoric part of the stiffness of a body, K = V + D, in the two matrices that the assembly
/// gives: K, and K' = D + V / part of the body with other bulk moduli.
class SplitStiffness {
  public:
    /// @param whole, other  K and K', with one pattern; kept alive by the caller
    /// @param part          above 0, below 1
    SplitStiffness(const SymmetricBlocks<double> &whole, const SymmetricBlocks<double> &other, double part)
        : whole_(&whole), other_(&other), weight_(part / (1.0 - part)) {}

    /// @return V a + D b, shape (3 n) [N]
    std::vector<double> product(std::span<const double> a, std::span<const double> b) const;
    /// @return v V + d D, shape (3 n, 3 n)
    SymmetricMatrix combined(double v, double d) const;

  private:
    const SymmetricBlocks<double> *whole_, *other_;
    double weight_; ///< V = weight (K' - K)
};

/// Lets the tractions of a load case go at t = 0 and follows a linear body that relaxes, with its mass: Newmark's
/// average acceleration (release.hpp), over each step of which the branches are integrated exactly for a displacement
/// that is linear in time (core::BranchStep). With v_m the mean of the velocities before and after a step of length h,
///     (2 M / h + alpha M + beta K + h / 2 (V + a D)) v_m
///         = 2 M v / h + f - V u - D (remaining u + sum over branches of (1 + fade) / 2 w),   a = remaining + sum of
///         gain
///     u <- u + h v_m,   v <- 2 v_m - v,   w <- fade w + gain h v_m.
/// It is of second order. Rayleigh damping is that of the instant stiffness. The strain energy of a record is what V,
/// D and the springs of the branches store.
/// @param body, system      of each other
/// @param load_case         of that body's mesh, with its release and its slow history, of which only the series counts
/// @param start             at rest
/// @param steps_per_record  of equal length between two records, at least 1
/// @throws std::runtime_error if the memory does not hold the factor
core::History release_relaxed(const core::Body &body, const ElasticSystem &system, const SplitStiffness &stiffness,
                              const core::LoadCase &load_case, RelaxedState start, int steps_per_record = 1);

/// The elements of a body whose shear moduli are those of the body and whose bulk moduli are multiplied by 1 / part: a
/// body whose shear moduli have fallen to a part of what they were, with all forces divided by that part. What is
/// mixed stays mixed, whatever Poisson's ratio becomes.
///
/// The matrix of the displacements is that of the body where all regions have a pressure, and so is its solver.
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

    /// Solution under the forces divided by the part.
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
