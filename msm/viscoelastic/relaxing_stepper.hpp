#pragma once

#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/dynamics/stepper.hpp"

namespace livermark::msm {

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
