#pragma once

#include <vector>

#include "core/problem.hpp"
#include "core/tool/stepper.hpp"

namespace livermark::msm {

using core::NodalConditions;

/// Takes the conditions of a load case from its facets to the nodes: a third of each facet's traction to its corners,
/// the acceleration by node mass. Where several constraints meet at a node, each component takes value and reaction
/// from the constraint of lowest index that prescribes it.
/// @param node_mass  shape (N) [kg]
NodalConditions nodal_conditions(const core::Problem &problem, const std::vector<double> &node_mass);

/// Sums nodal forces over each constraint.
/// @param conditions  of the problem
/// @param force       shape (N) [N], what the constraints exert on each node
/// @param press       what the places that press exert together [N]
/// @param touch       what the ball of LoadCase::touching exerts [N]
/// @return shape (P) [N]
std::vector<core::Vector3> constraint_forces(const core::Problem &problem, const NodalConditions &conditions,
                                             const std::vector<core::Vector3> &force, double press = 0.0,
                                             const core::Vector3 &touch = core::Vector3::Zero());

} // namespace livermark::msm
