#include "studies/run/work/work_plan.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <utility>

#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

/// Two bodies, the first the smaller one, with three load cases each, of which the first and the third are the same.
std::vector<core::Problem> six_problems() {
    std::vector<core::Problem> problems;
    for (const int bricks : {1, 2}) {
        const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {bricks, 1, 1}), {1e3, 5e3, 0.3});
        for (const double traction : {10.0, 20.0, 10.0}) {
            auto load_case = tests::empty_load_case(body->mesh);
            tests::prescribe(load_case, body->mesh, "x_min", {0.0, 0.0, 0.0});
            tests::pull(load_case, body->mesh, "x_max", {traction, 0.0, 0.0});
            problems.push_back({body, std::move(load_case)});
        }
    }
    return problems;
}

/// Two models that solve up to two case groups together, and two that solve one by one.
std::vector<core::Model> four_models() {
    std::vector<core::Model> models(4);
    models[0].most_together = models[2].most_together = 2;
    return models;
}

bool is_wanted_always(std::size_t /*problem*/) {
    return true;
}

/// How often each model is to solve each problem, and how often each problem is evaluated.
struct Counts {
    explicit Counts(const WorkPlan &plan) {
        for (const auto &item : plan.items)
            for (const auto &group : item.case_groups)
                for (const auto problem : group) {
                    for (const auto model : item.models)
                        ++solved[{model, problem}];
                    evaluated[problem] += item.models.empty() ? 1 : 0;
                }
    }
    std::map<std::pair<std::size_t, std::size_t>, int> solved;
    std::map<std::size_t, int> evaluated;
};

TEST(WorkPlan, SolvesAndEvaluatesEveryProblemOnce) {
    const Counts counts(plan_work(six_problems(), four_models(), is_wanted_always));
    for (std::size_t problem = 0; problem < 6; ++problem) {
        EXPECT_EQ(counts.evaluated.at(problem), 1);
        for (std::size_t model = 0; model < 4; ++model)
            EXPECT_EQ((counts.solved.at({model, problem})), 1) << model << " " << problem;
    }
}

TEST(WorkPlan, EvaluatesAlsoWhereNoModelSolvesBefore) {
    const Counts counts(plan_work(six_problems(), {}, is_wanted_always));
    EXPECT_TRUE(counts.solved.empty());
    EXPECT_EQ(counts.evaluated.size(), 6u);
}

TEST(WorkPlan, EvaluationsWaitForAllSolvesOfTheirProblemAndForNothingElse) {
    const auto plan = plan_work(six_problems(), four_models(), is_wanted_always);
    ASSERT_GE(plan.items.size(), 6U);
    for (std::size_t i = 0; i < plan.items.size(); ++i) {
        const auto &item = plan.items[i];
        if (!item.models.empty()) {
            EXPECT_TRUE(plan.waits_for[i].empty());
            continue;
        }
        const auto problem = item.case_groups.at(0).at(0);
        std::set<int> needed;
        for (std::size_t s = 0; s < plan.items.size(); ++s)
            for (const auto &group : plan.items[s].case_groups)
                if (!plan.items[s].models.empty() && std::ranges::find(group, problem) != group.end())
                    needed.insert(static_cast<int>(s));
        EXPECT_EQ(std::set<int>(plan.waits_for[i].begin(), plan.waits_for[i].end()), needed);
        EXPECT_TRUE(std::ranges::all_of(needed, [&](int s) { return s < static_cast<int>(i); }));
    }
}

TEST(WorkPlan, SolvesTogetherNoMoreCaseGroupsThanPaysOfOneBody) {
    const auto problems = six_problems();
    const auto plan = plan_work(problems, four_models(), is_wanted_always);
    ASSERT_GE(plan.items.size(), 6U);
    for (const auto &item : plan.items) {
        EXPECT_LE(item.case_groups.size(), 2u);
        for (const auto &group : item.case_groups)
            for (const auto problem : group)
                EXPECT_EQ(problems[problem].body, problems[item.case_groups.at(0).at(0)].body);
    }
}

/// The last digits depend on what is solved together, and a run that goes on is to come to the same ones.
TEST(WorkPlan, LeavesOutWhatIsNotWantedAndChangesNoCompany) {
    const auto company = [](const WorkPlan &plan) {
        std::map<std::pair<std::size_t, std::size_t>, std::set<std::size_t>> together; // of a model and a problem
        for (const auto &item : plan.items)
            for (const auto model : item.models)
                for (const auto &group : item.case_groups)
                    for (const auto problem : group)
                        for (const auto &others : item.case_groups)
                            together[{model, problem}].insert(others.begin(), others.end());
        return together;
    };
    const auto problems = six_problems();
    const auto whole = company(plan_work(problems, four_models(), is_wanted_always));
    for (std::size_t left_out = 0; left_out < problems.size(); ++left_out) {
        SCOPED_TRACE(left_out);
        const auto plan = plan_work(problems, four_models(), [&](std::size_t problem) { return problem != left_out; });
        EXPECT_EQ(Counts(plan).evaluated.size(), problems.size() - 1);
        auto expected = whole;
        std::erase_if(expected, [&](const auto &entry) { return entry.first.second == left_out; });
        for (auto &[pair, others] : expected)
            others.erase(left_out);
        EXPECT_EQ(company(plan), expected);
    }
}

TEST(WorkPlan, BeginsWithTheLargestBody) {
    const auto plan = plan_work(six_problems(), four_models(), is_wanted_always);
    EXPECT_GE(plan.items.front().case_groups.front().front(), 3u);
    EXPECT_LT(plan.items.back().case_groups.front().front(), 3u);
}

} // namespace
} // namespace livermark::studies
