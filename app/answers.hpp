#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/progress.hpp"
#include "app/run_task.hpp"
#include "app/time_spent.hpp"

namespace livermark::app {

/// What a model found before the contests.
struct Answer {
    std::string model;
    core::Problem problem;
    core::Solution solution;
};

/// Some problems of one body, each with another static answer.
struct TogetherGroups {
    std::vector<std::vector<std::size_t>> problems; ///< numbers of the problems of each group
    std::vector<int> body;                          ///< of each group
    std::vector<core::Model> models;                ///< that can solve several together

    int num_steps() const { return static_cast<int>(problems.size() * models.size()); }
};

TogetherGroups together_groups(const RunTask &task);

/// The problem at its target and at each amplitude.
/// @throws std::runtime_error if it cannot be scaled to its target
std::vector<core::Problem> loaded(const core::Problem &problem, const core::Model &baseline, const RunOptions &options);

/// Solves the problems of each group together, groups side by side. What fails has no answer, and is left to the
/// contest to tell.
/// @param is_wanted  whether a problem, as loaded, needs an answer
/// @param progress   gets num_steps() steps
/// @param spent      gets the time of each model
/// @throws core::InputError if the folder for temporary files cannot be written
std::vector<Answer> solve_together(const TogetherGroups &groups, const RunTask &task, const RunOptions &options,
                                   int num_workers, const std::function<bool(const core::Problem &)> &is_wanted,
                                   Progress &progress, TimeSpent &spent);

/// Models that first look whether there is an answer.
std::vector<core::Model> with_answers(std::vector<core::Model> models, std::vector<Answer> answers);

} // namespace livermark::app
