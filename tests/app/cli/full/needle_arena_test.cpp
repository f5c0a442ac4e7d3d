#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

#include "results/records/needle.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

std::filesystem::path needle_arena_folder(const std::string &name) {
    return std::filesystem::path(testing::TempDir()) / ("needle_arena_" + name + std::to_string(getpid()));
}

TEST(NeedleArenaCommand, WritesAFileWithTheReferenceAndTheRuns) {
    const auto folder = needle_arena_folder("runs");
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

TEST(NeedleArenaCommand, RefusesWhatGoesWithAnotherTool) {
    const auto says = [](const std::string &arguments, const std::string &what) {
        const auto refused =
            tests::livermark("arena --tool needle " + arguments + " --output " + needle_arena_folder("none").string());
        EXPECT_EQ(refused.status, 2) << arguments;
        EXPECT_NE(refused.output.find(what), std::string::npos) << refused.output;
    };
    says("--solve-reference", "leave --solve-reference and --iterations out");
    says("--friction 0.3", "the friction of a needle is that of its load case");
    says("--method nodal_neo_hookean_mass_scaled", "holds no needle, because");
    says("--load-case biopsy --body liver_tumours --needle tumour_9", "tumour_9");
    says("--load-case press_and_slide", "press_and_slide");
    says("--speed 0", "--speed");
    says("--speed 100", "give a lower --speed");
    const auto refused = tests::livermark("arena --speed 10 --method lloyd");
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.output.find("add --tool needle"), std::string::npos) << refused.output;
}

} // namespace
} // namespace livermark
