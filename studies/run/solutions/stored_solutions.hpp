#pragma once

#include <functional>
#include <string>
#include <vector>

#include "studies/run/prepared_models.hpp"
#include "studies/run/solutions/solution_store.hpp"
#include "studies/run/work/work_plan.hpp"

namespace livermark::studies {

/// The groups that a model takes part in.
std::vector<CaseGroup> part_of(const core::Model &model, const std::vector<CaseGroup> &case_groups,
                               const std::vector<core::Problem> &problems);

/// Lets models solve the problems of an item, and stores the solutions. What fails has none: the benchmark case tries
/// again, and says so.
/// @param starting  called with the name of each model and what it is about to solve
void solve_and_store(const WorkItem &item, const std::vector<core::Model> &models,
                     const std::vector<core::Problem> &problems, PreparedModels &prepared, const SolutionStore &store,
                     const std::function<void(const std::string &model, const std::string &about)> &starting);

} // namespace livermark::studies
