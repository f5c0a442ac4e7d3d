#pragma once

#include <string_view>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::models {

/// Whether a name is that of an interactive method that free_motion() takes: one without nodes of its own.
bool has_free_motion(std::string_view name);

/// The motion of an interactive method after all tractions of a load case are let go at t = 0: in steps of an output
/// interval with as many iterations as its users usually take, or, of a method with a longest stable step, as many as
/// that asks for.
/// @param name          has_free_motion()
/// @param problem       with a release, of which methods know the damping of the mass alone; whole nodes are
/// constrained
/// @param displacement  where it starts, at rest; shape (N) [m]
/// @return without frames and energies; if the motion leaves all bounds, diverged_at says when, and the records from
///   then on are NaN
core::History free_motion(std::string_view name, const core::Problem &problem,
                          const std::vector<core::Vector3> &displacement);

} // namespace livermark::models
