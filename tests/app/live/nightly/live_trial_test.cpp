#include <gtest/gtest.h>
#include <string>

#include "tests/app/live/rough_trial.hpp"

namespace livermark::live {
namespace {

/// docs/studies/live.md says what a longer one came to.
void expect_nothing_lost(const std::string &body, int num_steps, std::uint32_t seed) {
    const auto found = take_trial(body, num_steps, seed);
    EXPECT_EQ(found.num_steps, num_steps);
    EXPECT_GE(found.num_tools, 2 * num_steps);
    EXPECT_GT(found.num_choices, 1);
    EXPECT_EQ(found.num_restarts, 0);
    EXPECT_EQ(found.num_not_finite, 0);
    EXPECT_TRUE(found.is_fresh);
    EXPECT_GT(found.strongest, 2.0) << "the hand was a rough one [N]";
    EXPECT_LT(found.smallest_volume, 0.3);
}

TEST(LiveTrial, LosesNoMotionOfABeamOfAnOddNumberOfNodes) {
    expect_nothing_lost("small_beam", 150, 1);
}

TEST(LiveTrial, LosesNoMotionOfABoxWithALump) {
    expect_nothing_lost("lump", 80, 1);
}

TEST(LiveTrial, LosesNoMotionOfABoxWithACapsuleAndAVessel) {
    expect_nothing_lost("covered", 80, 1);
}

TEST(LiveTrial, LosesNoMotionOfTheBeam) {
    expect_nothing_lost("beam", 25, 1);
}

TEST(LiveTrial, LosesNoMotionOfTheHealthyLiver) {
    expect_nothing_lost("liver_healthy", 16, 1);
}

TEST(LiveTrial, LosesNoMotionOfTheLiverWithTumours) {
    expect_nothing_lost("liver_tumours", 16, 1);
}

} // namespace
} // namespace livermark::live
