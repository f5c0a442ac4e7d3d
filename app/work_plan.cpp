#include "app/work_plan.hpp"

#include <algorithm>

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

/// As many batches at once as models take less time for together.
void add_answers(WorkPlan &plan, const std::vector<std::size_t> &models, const std::vector<Batch> &batches,
                 std::size_t most_at_once) {
    const auto group = static_cast<int>(plan.waits_for.size());
    plan.waits_for.emplace_back();
    for (std::size_t first = 0; first < batches.size(); first += most_at_once) {
        const auto last = std::min(batches.size(), first + most_at_once);
        plan.items.push_back({models, {batches.begin() + first, batches.begin() + last}});
        plan.group.push_back(group);
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
        const auto first_group = static_cast<int>(plan.waits_for.size());
        if (!together.empty())
            add_answers(plan, together, wanted, most_together);
        if (model_by_model)
            for (const auto model : others)
                add_answers(plan, {model}, wanted, 1);
        const auto contests = static_cast<int>(plan.waits_for.size());
        auto &answers = plan.waits_for.emplace_back();
        for (int group = first_group; group < contests; ++group)
            answers.push_back(group);
        for (std::size_t b = 0; b < batches.problems.size(); ++b)
            if (batches.body[b] == body)
                for (const auto problem : batches.problems[b]) {
                    plan.items.push_back({{}, {{problem}}});
                    plan.group.push_back(contests);
                }
    }
    return plan;
}

} // namespace livermark::app
