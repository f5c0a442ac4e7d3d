#include "studies/progress.hpp"

#include <gtest/gtest.h>

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

} // namespace
} // namespace livermark::studies
