#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/model.hpp"

namespace livermark::app {

/// What a worker does in one go: lets models answer problems, or holds the contest of one.
struct WorkItem {
    std::vector<std::size_t> models; ///< numbers of those that answer; none in a contest
    /// Numbers of problems of one body, those with the same static answer together. In a contest a single one.
    std::vector<std::vector<std::size_t>> batches;
};

/// All of a run, for core::side_by_side().
struct WorkPlan {
    std::vector<WorkItem> items;
    std::vector<int> group;                  ///< of each item
    std::vector<std::vector<int>> waits_for; ///< of each item the items before it that it needs
};

/// Of each body first the answers, then the contests, which find theirs there. A group is what shares something that
/// models keep: models that solve problems together share one, and each of the others has its own if they answer by
/// themselves.
/// @param is_wanted    whether a problem needs answers
/// @param model_by_model  whether those that solve one problem at a time answer before the contests: that takes less
/// time
///   and memory than contest by contest where there are several workers, because none makes factors that another one
///   has, or keeps those of all models; but files come late
WorkPlan plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models, bool model_by_model,
                   const std::function<bool(std::size_t)> &is_wanted);

} // namespace livermark::app
