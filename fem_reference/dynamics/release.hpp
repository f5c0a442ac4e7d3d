#pragma once

#include <optional>
#include <vector>

#include "core/solution.hpp"
#include "fem_reference/dynamics/ritz_space.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::fem_reference {

/// Lets the tractions of a load case go at t = 0 and follows the body with Newmark's average acceleration and
/// consistent mass, a step per output interval: in the space of its load-dependent Ritz vectors as long as
/// extend_until_converged() finds one, and else as release_step_by_step() does. In the space the steps are taken again,
/// eight times as short, and History::observed_error is what they cost the motion of the probes.
/// @param body          that the system was assembled from
/// @param load_case     of that body's mesh, with its release
/// @param displacement  where it starts from rest, shape (3 n) [m]
/// @param solver        of the system's stiffness; the factor that it has serves if it holds what the motion holds
/// @throws std::runtime_error if the memory does not hold the factor
core::History release(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                      std::vector<double> displacement, ConstrainedSolver &solver);

/// The same of a stiffness that is there in its solutions only, as that of mixed elements is, with a step per output
/// interval in the space of Ritz vectors.
/// @param force   K u_0 where it starts, reactions included, shape (3 n) [N]
/// @param solve   statics of what the motion holds at zero
/// @return nothing if the space would have to have too many vectors, see extend_until_converged()
std::optional<core::History> release_by_statics(const core::Body &body, const ElasticSystem &system,
                                                const core::LoadCase &load_case,
                                                const std::vector<double> &displacement,
                                                const std::vector<double> &force, RitzSpace::SolveStatics solve);

/// The same motion in steps of the whole body, with a solve each: slow, obvious, and as good with any damping.
core::History release_step_by_step(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                                   std::vector<double> displacement);

} // namespace livermark::fem_reference
