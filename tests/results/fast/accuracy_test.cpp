#include "results/tables/overview.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

using Row = std::vector<std::string>;

TEST(ParetoFront, HasWhatNothingElseBeats) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<CostAndError> points{{1.0, 9.0}, {2.0, 5.0}, {2.0, 6.0}, {3.0, 5.0},
                                           {4.0, 1.0}, {nan, 0.0}, {0.0, nan}, {4.0, 1.0}};
    EXPECT_EQ(pareto_front(points), (std::vector<bool>{true, true, false, false, true, false, false, true}));
    EXPECT_TRUE(pareto_front({}).empty());
}

/// A static load case of models that have moved elsewhere.
Result at_rest_with_history() {
    auto result = tests::sample_result();
    result.problem.load_case.release.reset();
    result.problem.load_case.slow_history.reset();
    return result;
}

TEST(Accuracy, OfBodiesAtRestIsTheMeanErrorAndTheCostOfExplicitSteps) {
    std::vector<Result> results(2, at_rest_with_history());
    results[1].problem.load_case.name = "gravity";
    results[0].models[1].comparison->relative_l2 = 0.10;
    results[1].models[1].comparison->relative_l2 = 0.30;
    results[1].models[1].solution.explicit_steps = {0.0025, 1e-4, "scalar"};
    auto faster = results[0].models[1]; // and worse
    faster.name = "faster";
    faster.comparison->relative_l2 = 0.5;
    faster.solution.explicit_steps = {0.005, 1e-4, "scalar"};
    auto dominated = faster;
    dominated.name = "dominated";
    dominated.solution.explicit_steps = {0.001, 1e-4, "scalar"};
    for (auto &result : results)
        result.models.insert(result.models.end(), {faster, dominated});
    results.push_back(results[1]); // a second run of the same is no second load case
    results.push_back(results[1]); // and a multiple of a load counts in no mean
    results.back().problem.load_case.name += "@10";
    for (auto &model : results.back().models)
        if (model.comparison) {
            model.comparison->relative_l2 = 0.9;
            for (auto &place : model.comparison->tool.value().places) {
                place.stiffness = 0.9;
                place.path.clear();
            }
        }

    const auto layout = static_accuracy(results);
    // 0.8 of the shortest critical step; the reference has an error of its own, and no cost but that of its motion.
    EXPECT_EQ(layout.rows, (std::vector<Row>{{"box", "fem_p2", "3", "0.275", "-", "-", ""},
                                             {"box", "springs", "2", "0.05", "20.00", "20.0 !", "front"},
                                             {"box", "faster", "4", "0.025", "50.00", "20.0 !", "front"},
                                             {"box", "dominated", "0.8", "0.125", "50.00", "20.0 !", ""}}));
}

TEST(Accuracy, DoesNotRankAMeanOverSomeOfTheLoadCases) {
    std::vector<Result> results(2, at_rest_with_history());
    results[1].problem.load_case.name = "gravity";
    auto guest = results[0].models[1];
    guest.name = "guest"; // cheaper and better, where it took part
    guest.comparison->relative_l2 = 0.01;
    guest.solution.explicit_steps = {0.01, 1e-4, "scalar"};
    results[0].models.push_back(guest);
    const auto rows = static_accuracy(results).rows;
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_EQ(rows[1].back(), "front");
    EXPECT_EQ(rows[2], (Row{"box", "guest", "8", "0.0125", "1.00 (1 of 2)", "20.0 !", ""}));
}

TEST(Accuracy, HasNoErrorAtRestWhereOnlyAMotionStartedThere) {
    const auto result = tests::sample_result();
    const auto rows = static_accuracy({&result, 1}).rows;
    ASSERT_GE(rows.size(), 2u);
    EXPECT_EQ(rows[1][4], "-");
    EXPECT_EQ(rows[1][5], "-");
    EXPECT_EQ(rows[1][6], "");
}

TEST(Accuracy, InMotionHasARowForEachRun) {
    std::vector<Result> results(2, tests::sample_result());
    auto &longer = *results[1].models[1].solution.history;
    longer.integrator = "hourglass";
    longer.time_step = 0.004;
    longer.solve_seconds = 0.004; // for 0.04 s
    results[0].models[1].comparison->history->relative_l2 = 0.2;
    results[1].models[1].comparison->history->relative_l2 = 0.2;
    results[1].motion_uncertainty.reset();
    EXPECT_EQ(motion_accuracy(results).rows,
              (std::vector<Row>{
                  {"box", "pull_and_hang", "springs", "pendulum clock", "3", "0.275", "20.00", "", "8", "fem_p2"},
                  {"box", "pull_and_hang", "springs", "hourglass", "4", "0.00769", "20.00", "front", "-", "fem_p2"}}));
    results[1].models[1].comparison->history->reference = "fem_p2p1_refined_at_rims"; // not to be ranked with the other
    EXPECT_EQ(motion_accuracy(results).rows[0][7], "front");
    EXPECT_EQ(motion_accuracy(results).rows[1].back(), "fem_p2p1_refined_at_rims");
}

} // namespace
} // namespace livermark::results
