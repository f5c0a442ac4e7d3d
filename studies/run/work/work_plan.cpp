#include "studies/run/work/work_plan.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "studies/run/work/case_groups.hpp"

namespace livermark::studies {

namespace {

std::vector<CaseGroup> groups_of_body(const CaseGroups &all, int body) {
    std::vector<CaseGroup> groups;
    for (std::size_t b = 0; b < all.problems.size(); ++b)
        if (all.body[b] == body)
            groups.push_back(all.problems[b]);
    return groups;
}

using IsWanted = std::function<bool(std::size_t)>;

std::vector<CaseGroup> wanted_of(std::span<const CaseGroup> case_groups, const IsWanted &is_wanted) {
    std::vector<CaseGroup> wanted;
    for (const auto &case_group : case_groups) {
        CaseGroup some;
        std::ranges::copy_if(case_group, std::back_inserter(some), is_wanted);
        if (!some.empty())
            wanted.push_back(std::move(some));
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

/// As many case groups at once as models take less time for together: the same ones whatever of them is left to do.
void add_solves(WorkPlan &plan, const std::vector<std::size_t> &models, std::span<const CaseGroup> case_groups,
                std::size_t most_at_once, const IsWanted &is_wanted) {
    const int group = new_group(plan);
    for (std::size_t first = 0; first < case_groups.size(); first += most_at_once) {
        const auto some = case_groups.subspan(first, std::min(most_at_once, case_groups.size() - first));
        if (auto wanted = wanted_of(some, is_wanted); !wanted.empty())
            add_item(plan, group, {models, std::move(wanted)});
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

WorkPlan plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models,
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
        const auto groups = groups_of_body(case_groups, body);
        if (!together.empty())
            add_solves(plan, together, groups, most_together, is_wanted);
        for (const auto model : others)
            add_solves(plan, {model}, groups, 1, is_wanted);
        add_evaluations(plan, wanted_of(groups, is_wanted));
    }
    return plan;
}

} // namespace livermark::studies
