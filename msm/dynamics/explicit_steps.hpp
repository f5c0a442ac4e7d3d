#pragma once

#include <vector>

#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// What explicit time steps of a body come to: the critical step 2 / omega_max of symplectic Euler without damping, and
/// the time of such a step on the fastest kernel that knows the body, the shortest of a few dozen that are
/// really taken.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param highest     largest_angular_frequency() with these constrained [rad/s]
core::ExplicitSteps explicit_steps(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                   const NodalConditions &conditions, double highest);

/// Those of the same body where other components are constrained, which changes how long steps are but not how long
/// they take.
/// @param steps    of the body; measured
/// @param highest  with these constrained [rad/s]
core::ExplicitSteps constrained_otherwise(core::ExplicitSteps steps, double highest);

} // namespace livermark::msm
