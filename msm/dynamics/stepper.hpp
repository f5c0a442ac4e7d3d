#pragma once

#include "core/load_case.hpp"
#include "core/relaxation.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "msm/dynamics/time_step.hpp"

namespace livermark::msm {

/// Point masses with an elastic energy under dead loads, with unknown 3 i + component for node i:
/// M u'' = f - grad U(x + u) - alpha M v - beta K_m(x + u) v,
/// K_m the material tangent: on springs the last term is axial dashpots of beta k. It is beta K v at rest (Rayleigh
/// damping) and leaves rigid motion alone. Prescribed components stay where the motion starts.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param scaling     of masses in the accelerations; effective_mass, for implicit integrators, has none of it
/// @return of 3N unknowns
EquationOfMotion elastic_motion(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                const core::RayleighDamping &damping, const MassScaling &scaling = {});

/// 1/2 v^T M v [J]
double kinetic_energy(const EquationOfMotion &equation, const State &state);

/// Steps of one length.
struct Stepper {
    StepKernel kernel; ///< the scalar one where the wanted one does not know the body or the integrator
    std::function<void(State &, int num_steps)> take; ///< moves a state on
};

/// Steps of the motion that elastic_motion() describes.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param time_step   h [s], > 0
Stepper make_stepper(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                     const core::RayleighDamping &damping, const Integrator &integrator, double time_step,
                     StepKernel wanted);

struct ObservationOptions {
    /// Length of one run, in evaluations of the acceleration, so that every integrator may work equally long. A step
    /// just above the critical one needs a long run to be found out.
    int num_accelerations = 4000;
    int num_steps = 0; ///< and at least this many steps
    /// A run is unstable if the norm of its displacements gets larger than that of its start by this factor.
    double growth = 10.0;
    /// The steps that are tried are the whole powers of 1 + accuracy, in seconds.
    double accuracy = 0.002;
    MassScaling scaling{}; ///< of the masses
};

/// The step at which real runs stop being stable: a body at rest, without loads, with the components constrained that
/// are constrained, pushed off by a small displacement that is random and always the same. Found by bisection; nothing
/// is linearised, and nothing is known of the integrator but its steps.
/// @param body        at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  which components are constrained; its loads and the values of its displacements are left out
/// @param guess       where to look first [s], > 0; the solution does not depend on it
/// @return the largest step that was tried and stable [s]; infinity if every step up to 1e4 times the guess is, 0 if
///         none down to 1e-4 times the guess is
double observed_time_step(const Integrator &integrator, const ElasticBody &body, const Field &positions,
                          const NodalConditions &conditions, const core::RayleighDamping &damping, double guess,
                          const ObservationOptions &options = {});

/// Explicit time steps of a body: the critical step 2 / omega_max of symplectic Euler without damping, and
/// the time of such a step on the fastest kernel that knows the body, the shortest of a few dozen that are
/// really taken.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param highest     largest_angular_frequency() with these constrained [rad/s]
core::ExplicitSteps explicit_steps(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                   double highest);

/// Steps of the same body where other components are constrained, which changes how long steps are but not how long
/// they take.
/// @param steps    of the body; measured
/// @param highest  with these constrained [rad/s]
core::ExplicitSteps constrained_otherwise(core::ExplicitSteps steps, double highest);

// Rayleigh damping D = alpha M + beta K (equation 4 of Jurnal Teknologi 75, 10.11113/jt.v75.5068) from what can be
// measured, the damping ratios of modes: zeta = (alpha / omega + beta omega) / 2. core::rayleigh_damping() is the case
// of one ratio at two frequencies.

/// Damping by the mass alone: alpha = 2 zeta omega. Higher modes are damped less.
/// @param ratio  zeta >= 0
/// @param omega  of the mode that has this ratio [rad/s], > 0
/// @throws support::InputError if one of them is not so
core::RayleighDamping mass_proportional_damping(double ratio, double omega);

/// Damping by the stiffness alone: beta = 2 zeta / omega. Higher modes are damped more.
/// @param ratio  zeta >= 0
/// @param omega  of the mode that has this ratio [rad/s], > 0
/// @throws support::InputError if one of them is not so
core::RayleighDamping stiffness_proportional_damping(double ratio, double omega);

/// A ratio at one frequency and another ratio at another:
/// alpha = 2 omega_1 omega_2 (zeta_1 omega_2 - zeta_2 omega_1) / (omega_2^2 - omega_1^2),
/// beta = 2 (zeta_2 omega_2 - zeta_1 omega_1) / (omega_2^2 - omega_1^2).
/// @param ratio_1, ratio_2  zeta >= 0
/// @param omega_1, omega_2  [rad/s], > 0 and different
/// @throws support::InputError if they are not so, or if alpha or beta would be negative: the ratios may not differ by
///         more than the frequencies do
core::RayleighDamping two_mode_damping(double ratio_1, double omega_1, double ratio_2, double omega_2);

/// The body with the stresses s_e + part s of its terms that relax (RelaxingTerm), and nothing added: with
/// PronySeries::remaining() what is left after all time. Also of its preconditioner.
ElasticBody relaxed(const ElasticBody &body, double part);

/// Relaxation of the stresses of a body. Along each of them stand Maxwell branches, one for each time of the
/// series: their stresses h follow the stress s of the elastic law as core::BranchStep says, exactly where s is linear
/// in time over a step, and the stress is s_e + remaining() s + sum over branches of h.
///
/// Over a step h is known but for the s at its end. So the equilibrium there is that of an elastic body again, with the
/// energy U_e + instant_part() U_s + sum of (sum over branches of fade h - gain s at the start) e (the incremental
/// potential of Ortiz and Stainier 1999, Comput. Methods Appl. Mech. Engrg. 171). It is found as all others are.
class RelaxingBody {
  public:
    /// Without stress before.
    /// @param body  of which the terms that are RelaxingTerms relax
    RelaxingBody(ElasticBody body, core::PronySeries relaxation);

    const ElasticBody &instant() const { return body_; }
    const core::PronySeries &relaxation() const { return relaxation_; }

    /// The elastic body that stands for this one at the end of a step from now.
    /// @param step  [s], at least 0
    ElasticBody after(double step) const;

    /// Goes on to where that body came to.
    /// @param x  shape (3N) positions [m]
    void go_on(const Eigen::VectorXd &x, double step);

    /// Adds the forces of the terms and branches on the nodes, with dashpots of the instant stiffness: see
    /// ElasticTerm::add_force() [N].
    /// @param x  where it went on to last
    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta, Eigen::VectorXd &force) const;

    /// Energy that the springs of branches and what stays elastic store, with moduli of branches as at rest [J].
    /// @param x  where it went on to last
    double stored_energy(const Eigen::VectorXd &x) const;

    /// Heat that the dashpots of branches have made, with moduli as at rest [J].
    double dissipated_energy() const { return dissipated_; }

  private:
    /// One term that relaxes.
    struct Part {
        std::size_t term;                                     ///< of the body
        std::shared_ptr<const RelaxingTerm> instant, remains; ///< the term at once and after all time
        Eigen::VectorXd compliance;                           ///< (S)
        Eigen::VectorXd stress;                               ///< (S) s where it went on to last
        std::vector<Eigen::VectorXd> branches;                ///< (B) of (S), h
    };

    ElasticBody body_;
    core::PronySeries relaxation_;
    std::vector<Part> parts_;
    double dissipated_ = 0.0;
};

/// Steps of any integrator of point masses on springs that relax, the slow and obvious ones: elastic_motion() with what
/// the branches have taken off the stresses of RelaxingTerms. Of each branch that is q, with dq/dt = (g s - q) / tau.
/// It is held for m steps, and relaxes exactly between them for the time m h where the body is: Strang's splitting
/// (1968, SIAM J. Numer. Anal. 5(3)) of motion and relaxation, of second order in m h or of the order of the
/// integrator. Velocities of symplectic Euler stand half a step before positions; there branches relax where the body
/// was then.
class HeldSteps {
  public:
    /// Without stress before.
    /// @param body        as it is at once
    /// @param positions   shape (N) [m], where the body is at rest
    /// @param conditions  loads, and which components are constrained; these stay where they start
    /// @param time_step   h [s], > 0
    /// @param num_held    m, >= 1
    HeldSteps(const ElasticBody &body, const core::PronySeries &relaxation, const Field &positions,
              const NodalConditions &conditions, const core::RayleighDamping &damping, const Integrator &integrator,
              double time_step, int num_held);
    HeldSteps(const HeldSteps &) = delete;
    HeldSteps &operator=(const HeldSteps &) = delete;

    /// Lets stresses fade as if the body stayed in a displacement for that long [s], which may be infinite.
    /// @param displacement  shape (3N) [m]
    void relax(const Eigen::VectorXd &displacement, double time);

    /// Takes that many steps.
    void take(State &state, int num_steps);

  private:
    /// Stresses of a term, and how much each branch has taken off them.
    struct HeldStress {
        std::shared_ptr<const RelaxingTerm> term;
        std::vector<Eigen::VectorXd> taken; ///< (B) of (S), q
        Eigen::VectorXd sum;                ///< (S) of these
    };

    core::PronySeries relaxation_;
    Eigen::VectorXd rest_, free_per_mass_; ///< (3N)
    double time_step_;
    int num_held_;
    double back_; ///< [s] time by which positions are taken back along velocities where branches relax
    std::vector<HeldStress> stresses_;
    EquationOfMotion equation_;
    Step take_one_;
    int num_taken_ = 0; ///< since the branches were last where the body is
};

/// Steps in time of a body that relaxes, from the end of a slow history: of the fast kernels, or of HeldSteps where
/// these do not know the body or the integrator. Branches move once in as many steps as
/// FastStepOptions::relaxation_error allows. Where they start they have followed the displacements of the history,
/// which are taken to be linear between its records.
/// @param body      as it is at once
/// @param problem   with a slow history
/// @param history   at the times of it, see follow_history()
/// @param time_step h [s], > 0
/// @return for a state that begins at the last record
Stepper make_relaxing_stepper(const ElasticBody &body, const core::Problem &problem, const NodalConditions &conditions,
                              const core::RayleighDamping &damping, const Integrator &integrator, double time_step,
                              StepKernel wanted, std::span<const core::PathPoint> history);

} // namespace livermark::msm
