#include "studies/run/work/work_plan.hpp"

#include <algorithm>
#include <utility>

#include "studies/run/work/case_groups.hpp"

namespace livermark::studies {

namespace {

/// Case groups of one body, without what is not wanted.
std::vector<CaseGroup> wanted_groups(const CaseGroups &all, int body,
                                     const std::function<bool(std::size_t)> &is_wanted) {
    std::vector<CaseGroup> wanted;
    for (std::size_t b = 0; b < all.problems.size(); ++b) {
        if (all.body[b] != body)
            continue;
        CaseGroup case_group;
        std::ranges::copy_if(all.problems[b], std::back_inserter(case_group), is_wanted);
        if (!case_group.empty())
            wanted.push_back(std::move(case_group));
    }
    return wanted;
}

int new_group(const WorkPlan &plan) {
    return plan.group.empty() ? 0 : plan.group.back() + 1;
}

void add_item(WorkPlan &plan, int group, WorkItem item) {
    plan.items.push_back(std::move(item));
    plan.group.push_back(group);
    plan.waits_for.emplace_back();
}

/// As many case groups at once as models take less time for together.
void add_solves(WorkPlan &plan, const std::vector<std::size_t> &models, const std::vector<CaseGroup> &case_groups,
                std::size_t most_at_once) {
    const int group = new_group(plan);
    for (std::size_t first = 0; first < case_groups.size(); first += most_at_once) {
        const auto last = std::min(case_groups.size(), first + most_at_once);
        add_item(plan, group, {models, {case_groups.begin() + first, case_groups.begin() + last}});
    }
}

bool is_about(const WorkItem &item, std::size_t problem) {
    return std::ranges::any_of(
        item.case_groups, [&](const CaseGroup &case_group) { return std::ranges::count(case_group, problem) > 0; });
}

/// Evaluations of some case groups, which wait for what has solved their problems.
void add_evaluations(WorkPlan &plan, const std::vector<CaseGroup> &case_groups) {
    const int group = new_group(plan), num_solves = static_cast<int>(plan.items.size());
    for (const auto &case_group : case_groups)
        for (const auto problem : case_group) {
            add_item(plan, group, {{}, {{problem}}});
            for (int item = 0; item < num_solves; ++item)
                if (!plan.items[item].models.empty() && is_about(plan.items[item], problem))
                    plan.waits_for.back().push_back(item);
        }
}

} // namespace

WorkPlan plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models, bool model_by_model,
                   const std::function<bool(std::size_t)> &is_wanted) {
    std::vector<std::size_t> together, others;
    std::size_t most_together = 1;
    for (std::size_t m = 0; m < models.size(); ++m)
        if (models[m].most_together > 1) {
            together.push_back(m);
            most_together = std::max(most_together, models[m].most_together);
        } else {
            others.push_back(m);
        }
    const auto case_groups = case_groups_of(problems);
    WorkPlan plan;
    const int num_bodies = case_groups.body.empty() ? 0 : std::ranges::max(case_groups.body) + 1;
    for (int body = 0; body < num_bodies; ++body) {
        const auto wanted = wanted_groups(case_groups, body, is_wanted);
        if (!together.empty())
            add_solves(plan, together, wanted, most_together);
        if (model_by_model)
            for (const auto model : others)
                add_solves(plan, {model}, wanted, 1);
        add_evaluations(plan, wanted_groups(case_groups, body, [](std::size_t /*problem*/) { return true; }));
    }
    return plan;
}

} // namespace livermark::studies
