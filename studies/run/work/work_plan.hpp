#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/model.hpp"
#include "studies/run/work/case_groups.hpp"

namespace livermark::studies {

/// What a worker does in one go: lets models solve problems, or evaluates the benchmark case of
/// one.
struct WorkItem {
    std::vector<std::size_t> models; ///< numbers of those that solve; none in a benchmark case
    /// Numbers of problems of one body, those with the same static solution together. In a benchmark case a single one.
    std::vector<CaseGroup> case_groups;
};

/// All of a run, for support::run_in_process_pool().
struct WorkPlan {
    std::vector<WorkItem> items;
    std::vector<int> group;                  ///< of each item
    std::vector<std::vector<int>> waits_for; ///< of each item the items before it that it needs
};

/// Of each body first the solutions, model by model, then the benchmark cases, which find theirs there. A group is what
/// shares something that models keep: models that solve problems together share one, and each of the others has its
/// own, so that no worker makes factors that another one has, or keeps those of all models.
/// @param models     those that solve before the benchmark cases
/// @param is_wanted  whether a problem has no result yet; what is solved together does not depend on it, but for what
///   has a result
WorkPlan plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models,
                   const std::function<bool(std::size_t)> &is_wanted);

} // namespace livermark::studies
