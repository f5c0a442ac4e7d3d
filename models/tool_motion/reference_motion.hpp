#pragma once

#include "core/problem.hpp"
#include "core/tool/tool_motion.hpp"

namespace livermark::models {

/// What the motions of methods are compared with: neo-Hookean quadratic tetrahedra on the mesh refined at the rims
/// of places, by the energy-momentum method. Records of the nodes of the mesh.
/// @param problem          of a load case with a tool
/// @param level            how often the mesh is refined
/// @param steps_per_frame  >= 1
/// @return fewer records than all where it finds no next step
core::ToolHistory reference_motion(const core::Problem &problem, int level, int steps_per_frame);

} // namespace livermark::models
