#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "studies/run/run.hpp"
#include "studies/study.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

TEST(TimeSpent, GoesOnInAStageThatComesAgain) {
    TimeSpent spent;
    spent.add("lloyd", 1.0);
    spent.add("fem_p1", 2.0);
    spent.add("lloyd", 0.5);
    EXPECT_EQ(spent.stages(), (std::vector<std::pair<std::string, double>>{{"lloyd", 1.5}, {"fem_p1", 2.0}}));
}

TEST(TimeSpent, IsInOneStageAtATime) {
    TimeSpent spent;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 3; ++i) {
        spent.begin("solve");
        spent.begin("compare");
    }
    spent.stop();
    const double whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const auto &stages = spent.stages();
    ASSERT_EQ(stages.size(), 2u);
    EXPECT_EQ(stages[0].first, "solve");
    EXPECT_GT(stages[0].second, 0.0);
    EXPECT_GT(stages[1].second, 0.0);
    EXPECT_LE(stages[0].second + stages[1].second, whole);
}

TEST(TimeSpent, TextHasTheLongestStageFirstAndLeavesOutWhatIsLessThanAHundredth) {
    TimeSpent spent;
    spent.add("short", 0.5);
    spent.add("long", 60.0);
    spent.add("middle", 20.0);
    const auto text = spent.text();
    EXPECT_TRUE(text.starts_with("Time spent: 80.5 s\n")) << text;
    EXPECT_LT(text.find("long"), text.find("middle")) << text;
    EXPECT_EQ(text.find("short"), std::string::npos) << text;
    EXPECT_NE(text.find("75"), std::string::npos) << "per cent of the long one: " << text;
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::shared_ptr<const core::Body> bar_of(int bricks) {
    return tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {bricks, 1, 1}), {1e3, 5e3, 0.3});
}

/// Constrained at some patches in all components, or in one alone, and pulled at x_max.
core::Problem problem(const std::shared_ptr<const core::Body> &body, const std::vector<std::string> &fixed,
                      double traction, const std::vector<std::string> &sliding = {}) {
    auto load_case = tests::empty_load_case(body->mesh);
    for (const auto &patch : fixed)
        tests::prescribe(load_case, body->mesh, patch, {0.0, 0.0, 0.0});
    for (const auto &patch : sliding)
        tests::prescribe(load_case, body->mesh, patch, {nan, nan, 0.0});
    tests::pull(load_case, body->mesh, "x_max", {traction, 0.0, 0.0});
    return {body, std::move(load_case)};
}

/// Two bodies, the first the smaller one, with three load cases each, of which the first and the third are the same.
std::vector<core::Problem> six_problems() {
    std::vector<core::Problem> problems;
    for (const auto &body : {bar_of(1), bar_of(2)})
        for (const double traction : {10.0, 20.0, 10.0})
            problems.push_back(problem(body, {"x_min"}, traction));
    return problems;
}

/// Two models that solve up to two case groups together, and two that solve one by one.
std::vector<core::Model> four_models() {
    std::vector<core::Model> models(4);
    models[0].most_together = models[2].most_together = 2;
    return models;
}

constexpr auto is_wanted_always = [](std::size_t /*problem*/) { return true; };

/// Number of times that each model is to solve each problem, and that each problem is evaluated.
struct Counts {
    explicit Counts(const std::vector<WorkItem> &items) {
        for (const auto &item : items)
            for (const auto &group : item.case_groups)
                for (const auto problem : group) {
                    for (const auto model : item.models)
                        ++solved[{model, problem}];
                    evaluated[problem] += item.is_evaluation() ? 1 : 0;
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
    const auto items = plan_work(six_problems(), four_models(), is_wanted_always);
    ASSERT_GE(items.size(), 6U);
    for (std::size_t i = 0; i < items.size(); ++i) {
        const auto &item = items[i];
        if (!item.is_evaluation()) {
            EXPECT_TRUE(item.waits_for.empty());
            continue;
        }
        const auto problem = item.first_problem();
        std::set<int> needed;
        for (std::size_t s = 0; s < items.size(); ++s)
            for (const auto &group : items[s].case_groups)
                if (!items[s].is_evaluation() && std::ranges::find(group, problem) != group.end())
                    needed.insert(static_cast<int>(s));
        EXPECT_EQ(std::set<int>(item.waits_for.begin(), item.waits_for.end()), needed);
        EXPECT_TRUE(std::ranges::all_of(needed, [&](int s) { return s < static_cast<int>(i); }));
    }
}

TEST(WorkPlan, SolvesTogetherNoMoreCaseGroupsThanPaysOfOneBody) {
    const auto problems = six_problems();
    const auto items = plan_work(problems, four_models(), is_wanted_always);
    ASSERT_GE(items.size(), 6U);
    for (const auto &item : items) {
        EXPECT_LE(item.case_groups.size(), 2u);
        for (const auto &group : item.case_groups)
            for (const auto problem : group)
                EXPECT_EQ(problems[problem].body, problems[item.case_groups.at(0).at(0)].body);
    }
}

/// The last digits depend on what is solved together, and a run that goes on is to come to the same ones.
TEST(WorkPlan, LeavesOutWhatIsNotWantedAndChangesNoCompany) {
    const auto company = [](const std::vector<WorkItem> &items) {
        std::map<std::pair<std::size_t, std::size_t>, std::set<std::size_t>> together; // of a model and a problem
        for (const auto &item : items)
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
    const auto items = plan_work(six_problems(), four_models(), is_wanted_always);
    EXPECT_GE(items.front().first_problem(), 3u);
    EXPECT_LT(items.back().first_problem(), 3u);
}

TEST(CaseGroups, HaveOneStaticSolutionEach) {
    const auto body = bar_of(1);
    auto moving = problem(body, {"x_min"}, 10.0);
    moving.load_case.release = core::Release{.num_steps = 1, .output_interval = 0.1, .damping = {}, .probes = {}};
    const std::vector problems{problem(body, {"x_min"}, 10.0), problem(body, {"x_min"}, 20.0), moving};
    EXPECT_EQ(case_groups_of(problems), (std::vector<CaseGroup>{{0, 2}, {1}}));
}

TEST(CaseGroups, AreOfOneBodyTheLargestFirstAndThoseThatConstrainTheSameFollowEachOther) {
    const auto body = bar_of(1), twin = bar_of(1), large = bar_of(3);
    const auto groups_of = [](const std::vector<core::Problem> &problems) { return case_groups_of(problems); };
    EXPECT_EQ(groups_of({problem(body, {"x_min"}, 10.0), problem(twin, {"x_min"}, 10.0)}),
              (std::vector<CaseGroup>{{0}, {1}}));
    EXPECT_EQ(groups_of({problem(body, {"x_min"}, 1.0), problem(body, {"y_min"}, 1.0), problem(body, {"x_min"}, 2.0),
                         problem(body, {"y_min"}, 2.0)}),
              (std::vector<CaseGroup>{{0}, {2}, {1}, {3}}));
    EXPECT_EQ(groups_of({problem(body, {"x_min"}, 1.0), problem(large, {"x_min"}, 1.0)}),
              (std::vector<CaseGroup>{{1}, {0}}));
}

TEST(MostShared, IsWhatMostLoadCasesOfABodyConstrain) {
    const auto body = bar_of(2), other = bar_of(1);
    const std::vector problems{problem(body, {"x_min"}, 1.0),          problem(body, {"x_min"}, 1.0, {"z_min"}),
                               problem(body, {"x_min", "y_min"}, 1.0), problem(body, {"z_max"}, 1.0),
                               problem(other, {"y_min"}, 1.0),         problem(other, {"x_min", "y_min"}, 1.0)};
    const auto found = most_shared(problems);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].body, body);
    EXPECT_TRUE(core::constrain_the_same(found[0].load_case, problems[0].load_case));
    EXPECT_TRUE(core::constrain_the_same(found[1].load_case, problems[4].load_case));
    EXPECT_TRUE(most_shared(std::vector{problem(body, {"x_min"}, 1.0), problem(body, {"x_min"}, 2.0),
                                        problem(body, {"y_min"}, 1.0)})
                    .empty())
        << "no load case constrains more than another";
}

} // namespace
} // namespace livermark::studies
