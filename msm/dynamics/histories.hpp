#pragma once

#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::msm {

/// The steps of a release.
struct StepPlan {
    Integrator integrator;
    double critical_time_step = 0.0; ///< see critical_time_step() [s]
    int steps_per_record = 1;
    double time_step = 0.0; ///< output_interval / steps_per_record [s]
    StepKernel kernel = StepKernel::simd_float;
};

/// Divides the interval between two records into steps that are stable for the body at rest, by its largest
/// frequency and the damping of the load case. A stabilised method that is left to choose takes at least three, so that
/// its error is below a thousandth of the motion, and as many forces in each as make the fewest in all.
/// @param problem  with a release
/// @param highest  largest_angular_frequency() with what the problem holds [rad/s]
/// @throws support::InputError if the integrator is not there, if it has no stable step, or if the step asked for is
///   longer than the critical one and not forced
StepPlan plan_steps(const core::Problem &problem, double highest, const TimeStepping &choice);

/// The motion of the probes after all tractions of a load case are let go at t = 0.
/// @param problem       with a release
/// @param conditions    of the same load case without its tractions
/// @param displacement  where it starts, shape (N) [m]
/// @param path          of a body that relaxes, its slow history so far, which ends there: see make_relaxing_stepper().
///   Its strain energy is RelaxingBody::stored_energy(), with branches that follow the records
/// @return if the motion leaves all bounds, diverged_at says when, and the records from then on are NaN
core::History release(const core::Problem &problem, const ElasticBody &body, const NodalConditions &conditions,
                      const Field &displacement, const StepPlan &plan, std::span<const core::PathPoint> path = {});

/// Cost of a relaxation.
struct Relaxation {
    Equilibrium equilibrium; ///< without the linear solution; num_iterations are steps
    double time_step = 0.0;  ///< [s]
};

/// Place where a body comes to rest, found by letting it move under damping (dynamic relaxation): steps of a safe part
/// of the critical length, and damping by the mass, alpha = 2 omega, critical for the mode that the motion is in, with
/// omega^2 = u^T F(u) / u^T M u of the elastic forces F, looked at again after every few steps.
/// (P. Underwood 1983, Dynamic relaxation, in: Computational Methods for Transient Analysis)
/// @param integrator  explicit
/// @param body, positions, conditions  as for find_equilibrium()
/// @return with forces out of balance of 1e-9 of all forces at work, in their norms; status not_converged after
/// max_steps, diverged where the motion is lost
Relaxation relax(const Integrator &integrator, const ElasticBody &body, const Field &positions,
                 const NodalConditions &conditions, int max_steps = 100000);

/// Motion of a body that relaxes under a slow history.
struct FollowedHistory {
    /// At SlowHistory::whole_load_record(), or where it ended; iterations and factors are those of the whole history.
    Equilibrium end;
    double stored_energy = 0.0;          ///< there [J]
    std::vector<core::PathPoint> points; ///< at SlowHistory::times, as far as it came
    int num_steps = 0;                   ///< in time
};

/// Follows LoadCase::slow_history without masses, one step from each time to the next: the stresses of the elastic law
/// are taken to be linear in time over it (RelaxingBody). In the small regime the body is linearised at rest, and a
/// step is one linear system with the stiffness K_e + instant_part() K_s; steps of one length share its factor. In the
/// large regime it is an equilibrium (EquilibriumSearch), and a step without one is taken again in halves. The error at
/// a given time is of second order in the steps.
/// @param body       as it is at once
/// @param problem    with a slow history
/// @param node_mass  shape (N) [kg]
/// @return status not_converged with the points as far as it came
FollowedHistory follow_history(const ElasticBody &body, const core::Problem &problem,
                               const std::vector<double> &node_mass);

} // namespace livermark::msm
