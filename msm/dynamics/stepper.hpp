#pragma once

#include <functional>

#include "core/load_case.hpp"
#include "msm/dynamics/time_stepping.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// What takes steps of one length.
struct Stepper {
    StepKernel kernel; ///< the scalar one where the wanted one does not know the body or the integrator
    std::function<void(State &, int num_steps)> take; ///< moves a state on
};

/// Of the motion that elastic_motion() describes.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param time_step   h [s], > 0
Stepper make_stepper(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                     const NodalConditions &conditions, const core::RayleighDamping &damping,
                     const Integrator &integrator, double time_step, StepKernel wanted);

} // namespace livermark::msm
