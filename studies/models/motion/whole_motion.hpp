#pragma once

#include <string_view>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/tool/tool_motion.hpp"

/// Motions from beginning to end.
namespace livermark::models {

/// Whether a name is that of an interactive method that free_motion() takes: one without nodes of its own.
bool has_free_motion(std::string_view name);

/// The motion of an interactive method after all tractions of a load case are let go at t = 0: in steps of an output
/// interval with as many iterations as its users usually take, or, of a method with a longest stable step, as many as
/// that asks for.
/// @param name          has_free_motion()
/// @param problem       with a release, of which methods know the damping of the mass alone; whole nodes are
///                      constrained
/// @param displacement  where it starts, at rest; shape (N) [m]
/// @return without frames and energies; if the motion leaves all bounds, diverged_at says when, and the records from
///   then on are NaN
core::History free_motion(std::string_view name, const core::Problem &problem,
                          const std::vector<core::Vector3> &displacement);

/// The motion that those of methods are compared with: neo-Hookean quadratic tetrahedra on the mesh refined at the rims
/// of places, by the energy-momentum method. Records of the nodes of the mesh.
/// @param problem          of a load case with a tool
/// @param level            how often the mesh is refined
/// @param steps_per_frame  >= 1
/// @return fewer records than all where it finds no next step
core::ToolHistory reference_motion(const core::Problem &problem, int level, int steps_per_frame);

} // namespace livermark::models
