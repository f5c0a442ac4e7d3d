#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <tuple>
#include <unistd.h>
#include <vector>

#include "results/records/arena.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {

/// 25 iterations are no whole steps of ten, and one is the same in every setting.
TEST(ArenaSettings, ShareANumberOfIterationsAmongSteps) {
    const auto folder = std::filesystem::path(testing::TempDir()) / ("arena_settings_" + std::to_string(getpid()));
    const auto done = tests::livermark("arena --body liver_healthy --method xpbd_springs --mesh 1 --budget 1 "
                                       "--iterations 1 20 25 --output " +
                                       folder.string());
    ASSERT_EQ(done.status, 0) << done.output;
    const auto arena = results::read_arena(folder / "liver_healthy" / "arena.h5");
    std::vector<std::tuple<std::string, int, int>> moved;
    for (const auto &run : arena.series)
        moved.emplace_back(run.setting, run.steps, run.iterations);
    const decltype(moved) expected{{"one step", 1, 1},        {"one step", 1, 20},      {"one step", 1, 25},
                                   {"ten iterations", 2, 10}, {"one iteration", 20, 1}, {"one iteration", 25, 1}};
    EXPECT_TRUE(std::ranges::is_permutation(moved, expected));
    for (const auto &run : arena.runs)
        EXPECT_TRUE(run.setting != "ten iterations" || run.steps > 1);
    std::filesystem::remove_all(folder);
}

} // namespace livermark
