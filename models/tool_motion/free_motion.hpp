#pragma once

#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "interactive/method.hpp"

namespace livermark::models {

/// The motion of an interactive method after all tractions of a load case are let go at t = 0: in steps of an output
/// interval with as many iterations as its users usually take, or, of a method with a longest stable step, as many as
/// that asks for.
/// @param problem       with a release, of which methods know the damping of the mass alone; whole nodes are
/// constrained
/// @param displacement  where it starts, at rest; shape (N) [m]
/// @return without frames and energies; if the motion leaves all bounds, diverged_at says when, and the records from
///   then on are NaN
core::History free_motion(const livermark::interactive::Method &method, const core::Problem &problem,
                          const std::vector<core::Vector3> &displacement);

} // namespace livermark::models
