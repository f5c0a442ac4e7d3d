#include <algorithm>
#include <functional>
#include <gtest/gtest.h>

#include "core/processor_time.hpp"
#include "studies/arena/frame_loop.hpp"

namespace livermark::studies {
namespace {

/// A frame that takes so much time of the processor for a number of steps [s].
std::function<void(const models::Effort &)> frame_of(const std::function<double(int)> &seconds) {
    return [=](const models::Effort &effort) {
        const double end = core::processor_seconds() + seconds(effort.steps);
        while (core::processor_seconds() < end)
            ;
    };
}

TEST(LargestEffort, FillsTheBudgetWhereTimeIsALine) {
    const auto fits =
        largest_effort(frame_of([](int steps) { return 1e-4 + 2e-4 * steps; }), models::Setting::one_iteration, 4e-3);
    ASSERT_TRUE(fits);
    EXPECT_NEAR(fits->effort.steps, 19, 3);
}

/// As under a ball, where one step of a whole frame is solved five times, and short ones once.
TEST(LargestEffort, FitsWhereOneStepTakesAsLongAsMany) {
    const auto fits = largest_effort(frame_of([](int steps) { return steps < 4 ? 2e-3 / steps : 2e-4 * steps; }),
                                     models::Setting::one_iteration, 4e-3);
    ASSERT_TRUE(fits);
    EXPECT_NEAR(fits->effort.steps, 20, 3); // a line through the first two would say 20,000
    EXPECT_NEAR(fits->seconds, 4e-3, 4e-4);
}

/// As conjugate gradients that have converged: more iterations are a limit, and take no more time.
TEST(LargestEffort, SaysWhereAMethodStopsEarlier) {
    const auto frame = [](const models::Effort &effort) {
        const double end = core::processor_seconds() + 5e-5 * std::min(effort.iterations, 20);
        while (core::processor_seconds() < end)
            ;
    };
    const auto stops = largest_effort(frame, models::Setting::one_step, 4e-3);
    ASSERT_TRUE(stops);
    EXPECT_TRUE(stops->stops_early);
    EXPECT_GT(stops->effort.iterations, 100);
    EXPECT_LT(stops->seconds, 2e-3);
    const auto fills = largest_effort(frame, models::Setting::one_step, 5e-4);
    ASSERT_TRUE(fills);
    EXPECT_FALSE(fills->stops_early);
}

TEST(LargestEffort, IsTheLeastWhereNothingFits) {
    const auto fits =
        largest_effort(frame_of([](int steps) { return 2e-3 * steps; }), models::Setting::one_iteration, 1e-3);
    ASSERT_TRUE(fits);
    EXPECT_EQ(fits->effort.steps, 1);
}

} // namespace
} // namespace livermark::studies
