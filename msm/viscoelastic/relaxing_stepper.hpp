#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/relaxation.hpp"
#include "core/solution.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

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
    HeldSteps(const ElasticBody &body, const core::PronySeries &relaxation, const std::vector<core::Vector3> &positions,
              const NodalConditions &conditions, const core::RayleighDamping &damping, const Integrator &integrator,
              double time_step, int num_held);
    ~HeldSteps();
    HeldSteps(HeldSteps &&) noexcept;
    HeldSteps &operator=(HeldSteps &&) noexcept;

    /// Lets stresses fade as if the body stayed in a displacement for that long [s], which may be infinite.
    /// @param displacement  shape (3N) [m]
    void relax(const Eigen::VectorXd &displacement, double time);

    /// Takes that many steps.
    void take(State &state, int num_steps);

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
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
