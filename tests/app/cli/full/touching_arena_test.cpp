#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

#include "results/records/arena.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

std::filesystem::path arena_folder(const std::string &name) {
    return std::filesystem::path(testing::TempDir()) / ("touching_arena_" + name + std::to_string(getpid()));
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

TEST(TouchingArena, RefusesWhatGoesWithAnotherTool) {
    const auto says = [](const std::string &arguments, const std::string &what) {
        const auto refused = tests::livermark("arena " + arguments + " --output " + arena_folder("none").string());
        EXPECT_EQ(refused.status, 2);
        EXPECT_NE(refused.output.find(what), std::string::npos) << refused.output;
    };
    says("--tool touching --solve-reference", "the reference motion knows no contact");
    says("--friction 0.3 --method lloyd", "a glued tool has no friction");
    says("--tool touching --friction -1 --method lloyd", "--friction");
}

} // namespace
} // namespace livermark
