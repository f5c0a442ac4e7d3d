#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <tuple>
#include <unistd.h>
#include <vector>

#include "results/records/arena.hpp"
#include "results/records/needle.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

std::filesystem::path arena_folder(const std::string &name) {
    return std::filesystem::path(testing::TempDir()) / ("arena_" + name + std::to_string(getpid()));
}

/// A file of its own, which says which tool it was; forces and no errors, because no reference motion has contact.
TEST(TouchingArena, WritesForcesAndNoErrorsWhereThereIsNoReference) {
    const auto folder = arena_folder("forces");
    const auto done = tests::livermark(
        "arena --tool touching --friction 0.3 --method lloyd --mesh 1 --budget 100 --output " + folder.string());
    ASSERT_EQ(done.status, 0) << done.output;
    EXPECT_NE(done.output.find("a ball of 20 mm that touches, with a friction of 0.3"), std::string::npos)
        << done.output;
    EXPECT_NE(done.output.find("there are forces and no errors"), std::string::npos) << done.output;
    EXPECT_FALSE(std::filesystem::exists(folder / "liver_healthy" / "arena.h5"));
    const auto arena = results::read_arena(folder / "liver_healthy" / "arena_touching_0.3.h5");
    EXPECT_EQ(arena.tool, results::touching_tool);
    EXPECT_EQ(arena.friction, 0.3);
    EXPECT_TRUE(arena.reference.empty());
    ASSERT_EQ(arena.runs.size(), 1U);
    const auto &run = arena.runs.front();
    EXPECT_EQ(run.outcome, results::ArenaOutcome::ok);
    EXPECT_GT(run.pressed_force, 0.1);
    EXPECT_LT(run.pressed_force, 10.0);
    EXPECT_GT(run.deepest, 0.0);
    EXPECT_LT(run.deepest, 2e-3);
    EXPECT_TRUE(std::isnan(run.errors.contact));
    std::filesystem::remove_all(folder);
}

/// 25 iterations are no whole steps of ten, and one is the same in every setting.
TEST(ArenaSettings, ShareANumberOfIterationsAmongSteps) {
    const auto folder = arena_folder("settings");
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

TEST(NeedleArenaCommand, WritesAFileWithTheReferenceAndTheRuns) {
    const auto folder = arena_folder("needle");
    const auto done = tests::livermark("arena --tool needle --method lloyd corotational_implicit --budget 30 --speed "
                                       "60 --rest 0 --reference-on-mesh --output " +
                                       folder.string());
    ASSERT_EQ(done.status, 0) << done.output;
    EXPECT_NE(done.output.find("the reference is the static fem_p2p1"), std::string::npos) << done.output;
    const auto file = results::read_needles_file(folder / "liver_healthy" / "needle_arena.nick.h5");
    ASSERT_EQ(file.needles.size(), 1U);
    const auto &study = file.needles.front();
    ASSERT_EQ(study.runs.size(), 1U);
    ASSERT_TRUE(study.arena.has_value());
    ASSERT_GE(study.arena->runs.size(), 3U); // of lloyd, and of the settings that fit
    EXPECT_EQ(study.arena->speed, 0.06);
    for (const auto &run : study.arena->runs) {
        EXPECT_LT(run.target_error, 3e-3) << run.method;
        EXPECT_NEAR(run.forces.peak, study.arena->reference_forces.peak, 0.3) << run.method;
    }
    std::filesystem::remove_all(folder);
}

} // namespace
} // namespace livermark
