#pragma once

#include <cstddef>
#include <vector>

#include "core/load_case.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/kernels/step_workspace.hpp"

namespace livermark::msm {

/// Lays a body out for steps, with room for all that these write. Nodes have no mass and stand at zero as yet.
/// @param at_rest       shape (N) [m], less their mean
/// @param num_branches  of what relaxes; 0 if nothing does
/// @param num_threads   that will take the steps
/// @param plan          told where everything went if options.may_be_cut, or if something relaxes
template <class T>
StepWorkspace<T> make_workspace(const StepParts &parts, const std::vector<core::Vector3> &at_rest,
                                const StepScheme &scheme, const core::RayleighDamping &damping, double time_step,
                                const FastStepOptions &options, std::size_t num_branches, int num_threads,
                                SlicedPlan &plan);

/// For what part_sliced_body() has added to the body. Nodes keep their places, and new ones stand at zero as yet, with
/// no mass.
template <class T> void make_room_after_parting(const RowMap &map, int num_threads, StepWorkspace<T> &at);

/// For each thread, for the longest star of a body that is there now.
template <class T> void make_room_for_stars(StepWorkspace<T> &at, int num_threads);

/// Memory that every step reads or writes [bytes].
template <class T> std::size_t working_set(const StepWorkspace<T> &at);

} // namespace livermark::msm
