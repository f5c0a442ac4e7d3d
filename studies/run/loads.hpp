#pragma once

#include <functional>
#include <string>
#include <vector>

#include "studies/run/prepared_models.hpp"
#include "studies/run/work/run_task.hpp"

namespace livermark::studies {

/// A problem of a run at its target and one of the amplitudes.
struct LoadedProblem {
    std::size_t number; ///< of the problem in the task
    core::Problem problem;
};

/// Loads all problems of a task, in an order in which models can make use of what they keep: see case_groups_of(). It
/// is the same on all MPI ranks, who all have to call this.
/// @param prepared  what the baseline solves with
/// @param failed  called for what cannot be scaled to its target, with the reason
std::vector<LoadedProblem> load_all(const RunTask &task, const RunOptions &options, PreparedModels &prepared,
                                    const std::function<void(std::size_t number, const std::string &reason)> &failed);

/// What they are of.
std::vector<core::Problem> problems_of(const std::vector<LoadedProblem> &loads);

/// For people: body and load case.
std::string name_of(const core::Problem &problem);

} // namespace livermark::studies
