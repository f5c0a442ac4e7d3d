#include <functional>
#include <gtest/gtest.h>

#include "core/processor_time.hpp"
#include "studies/arena/arena_run.hpp"

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

TEST(LargestEffort, IsTheLeastWhereNothingFits) {
    const auto fits =
        largest_effort(frame_of([](int steps) { return 2e-3 * steps; }), models::Setting::one_iteration, 1e-3);
    ASSERT_TRUE(fits);
    EXPECT_EQ(fits->effort.steps, 1);
}

} // namespace
} // namespace livermark::studies
