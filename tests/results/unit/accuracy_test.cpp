#include "results/tables/accuracy.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/sample_result.hpp"

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

TEST(Accuracy, OfBodiesAtRestIsTheMeanErrorAndTheCostOfExplicitSteps) {
    std::vector<Result> results(2, tests::sample_result());
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
    results[0].models.insert(results[0].models.end(), {faster, dominated});
    results.push_back(results[1]); // a second run of the same is no second load case

    const auto layout = static_accuracy(results);
    // 0.8 of the shortest critical step; the reference has an error of its own, and no cost but that of its motion.
    EXPECT_EQ(layout.rows, (std::vector<Row>{{"box", "fem_p2", "3", "0.275", "-", "-", ""},
                                             {"box", "springs", "2", "0.05", "20.00", "20.0 !", "front"},
                                             {"box", "faster", "4", "0.025", "50.00", "20.0 !", "front"},
                                             {"box", "dominated", "0.8", "0.125", "50.00", "20.0 !", ""}}));
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
    EXPECT_EQ(
        motion_accuracy(results).rows,
        (std::vector<Row>{{"box", "pull_and_hang", "springs", "pendulum clock", "3", "0.275", "20.00", "", "8"},
                          {"box", "pull_and_hang", "springs", "hourglass", "4", "0.00769", "20.00", "front", "-"}}));
}

} // namespace
} // namespace livermark::results
