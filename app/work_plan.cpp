#include "app/work_plan.hpp"

#include <algorithm>
#include <utility>

#include "app/batches.hpp"

namespace livermark::app {

namespace {

using Batch = std::vector<std::size_t>;

/// Batches of one body, without what is not wanted.
std::vector<Batch> wanted_batches(const Batches &all, int body, const std::function<bool(std::size_t)> &is_wanted) {
    std::vector<Batch> wanted;
    for (std::size_t b = 0; b < all.problems.size(); ++b) {
        if (all.body[b] != body)
            continue;
        Batch batch;
        std::ranges::copy_if(all.problems[b], std::back_inserter(batch), is_wanted);
        if (!batch.empty())
            wanted.push_back(std::move(batch));
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

/// As many batches at once as models take less time for together.
void add_answers(WorkPlan &plan, const std::vector<std::size_t> &models, const std::vector<Batch> &batches,
                 std::size_t most_at_once) {
    const int group = new_group(plan);
    for (std::size_t first = 0; first < batches.size(); first += most_at_once) {
        const auto last = std::min(batches.size(), first + most_at_once);
        add_item(plan, group, {models, {batches.begin() + first, batches.begin() + last}});
    }
}

bool is_about(const WorkItem &item, std::size_t problem) {
    return std::ranges::any_of(item.batches,
                               [&](const Batch &batch) { return std::ranges::count(batch, problem) > 0; });
}

/// Contests of some batches, which wait for what has answered their problems.
void add_contests(WorkPlan &plan, const std::vector<Batch> &batches) {
    const int group = new_group(plan), num_answers = static_cast<int>(plan.items.size());
    for (const auto &batch : batches)
        for (const auto problem : batch) {
            add_item(plan, group, {{}, {{problem}}});
            for (int item = 0; item < num_answers; ++item)
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
        if (models[m].solve_together) {
            together.push_back(m);
            most_together = std::max(most_together, models[m].most_together);
        } else {
            others.push_back(m);
        }
    const auto batches = batches_of(problems);
    WorkPlan plan;
    const int num_bodies = batches.body.empty() ? 0 : std::ranges::max(batches.body) + 1;
    for (int body = 0; body < num_bodies; ++body) {
        const auto wanted = wanted_batches(batches, body, is_wanted);
        if (!together.empty())
            add_answers(plan, together, wanted, most_together);
        if (model_by_model)
            for (const auto model : others)
                add_answers(plan, {model}, wanted, 1);
        add_contests(plan, wanted_batches(batches, body, [](std::size_t /*problem*/) { return true; }));
    }
    return plan;
}

} // namespace livermark::app
