#pragma once

#include "core/problem.hpp"
#include "core/tool/tool_motion.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/hyperelastic/reference_element.hpp"

namespace livermark::hyperelastic {

/// Follows a body that a tool moves with EnergyMomentum, from rest.
/// @param problem          of a load case with a tool
/// @param degree           1 or 2, of elements in displacements alone
/// @param steps_per_frame  >= 1
/// @return the records as far as the motion came: fewer than all where it finds no next step
/// @throws std::invalid_argument for a load case without a tool, and elements that do not exist
/// @throws std::runtime_error if the memory does not hold a factor
core::ToolHistory move_tool(const core::Problem &problem, const MaterialLaw &law, int degree, int steps_per_frame,
                            TetrahedronRule rule = TetrahedronRule::fourteen_points);

} // namespace livermark::hyperelastic
