#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/model.hpp"

namespace livermark::studies {

/// Numbers of problems of one body with the same static solution, which models keep: one worker takes them one after
/// the other, so that what is kept does not depend on how many workers there are.
using CaseGroup = std::vector<std::size_t>;

/// Groups of all problems. Those that constrain the same components of a body come one after the other: models keep the
/// last factor. Bodies come by their number of tetrahedra, the largest first: it would keep the others waiting at the
/// end. What comes first otherwise stays first.
std::vector<CaseGroup> case_groups_of(std::span<const core::Problem> problems);

/// Of each body with load cases that constrain all that another one constrains and more, the first problem whose
/// constrained components are constrained in most of them.
std::vector<core::Problem> most_shared(std::span<const core::Problem> problems);

/// Work that a worker does in one go, as support::run_in_process_pool() hands it out: models solve problems of one
/// body, or the benchmark case of one problem is evaluated.
struct WorkItem {
    std::vector<std::size_t> models;    ///< numbers of those that solve; none in a benchmark case
    std::vector<CaseGroup> case_groups; ///< to solve; in a benchmark case a single problem
    int group;                          ///< of items that share something that models keep
    std::vector<int> waits_for{};       ///< items before it that it needs

    bool is_evaluation() const { return models.empty(); }
    std::size_t first_problem() const { return case_groups.front().front(); }
};

/// Items of a run: of each body first the solutions, model by model, then the benchmark cases, which find theirs there.
/// Models that solve problems together share a group, and each of the others has its own, so that no worker makes
/// factors that another one has, or keeps those of all models.
/// @param models     those that solve before the benchmark cases
/// @param is_wanted  whether a problem has no result yet; what is solved together does not depend on it, but for what
///   has a result
std::vector<WorkItem> plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models,
                                const std::function<bool(std::size_t)> &is_wanted);

} // namespace livermark::studies
