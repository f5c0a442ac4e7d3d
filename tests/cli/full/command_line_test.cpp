#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>

#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

using tests::livermark;

std::filesystem::path scratch_folder() {
    const auto *test = testing::UnitTest::GetInstance()->current_test_info();
    auto folder = std::filesystem::path(testing::TempDir()) / "livermark_command_line" / test->name();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

TEST(CommandLine, HelpAndVersionAreNoErrors) {
    for (const char *arguments : {"--help", "run --help", "list --help", "mesh --help", "mesh liver --help",
                                  "mesh cut --help", "mesh check --help", "modes --help", "cohort --help",
                                  "arena --help", "stability --help", "table --help", "report --help", "--version"}) {
        const auto outcome = livermark(arguments);
        EXPECT_EQ(outcome.status, 0) << arguments << "\n" << outcome.output;
        EXPECT_FALSE(outcome.output.empty());
    }
}

TEST(CommandLine, ListsWhatShips) {
    EXPECT_NE(livermark("list bodies").output.find("liver_healthy"), std::string::npos);
    EXPECT_NE(livermark("list load-cases").output.find("palpation"), std::string::npos);
    EXPECT_NE(livermark("list moving-load-cases").output.find("press_and_slide"), std::string::npos);
    EXPECT_NE(livermark("list slow-load-cases").output.find("hold_after_press"), std::string::npos);
    EXPECT_NE(livermark("list methods").output.find("xpbd_springs"), std::string::npos);
    EXPECT_NE(livermark("list models").output.find("fem_p2"), std::string::npos);
    EXPECT_NE(livermark("list spring-laws").output.find("lloyd"), std::string::npos);
}

TEST(CommandLine, ModesPrintsFrequenciesAndWritesThem) {
    const auto folder = scratch_folder();
    const auto outcome =
        livermark("modes liver_healthy --model fem_p1 --model lloyd --count 3 --output " + folder.string());
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("fem_p1 [Hz]"), std::string::npos) << outcome.output;
    const auto result = results::read_result(folder / "liver_healthy" / "modes.traction.h5");
    ASSERT_EQ(result.modes.size(), 2u);
    EXPECT_EQ(result.modes[0].name, "fem_p1");
    EXPECT_EQ(result.modes[1].name, "lloyd");
    for (const auto &model : result.modes) {
        ASSERT_EQ(model.modes.count(), 3);
        const double first = model.modes.angular_frequency[0] / (2.0 * std::numbers::pi);
        EXPECT_NE(outcome.output.find(fmt::format("{:.4f}", first)), std::string::npos) << outcome.output;
    }
}

TEST(CommandLine, StabilityOnlyPredictsIfToldSo) {
    const auto folder = scratch_folder();
    const auto outcome = livermark("stability liver_healthy --no-observed --markdown --integrator velocity_verlet "
                                   "explicit_euler --output " +
                                   folder.string());
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("| explicit_euler | none | - | - |"), std::string::npos) << outcome.output;
    EXPECT_LT(outcome.output.find("| velocity_verlet |"), outcome.output.find("| explicit_euler |")) << outcome.output;
    EXPECT_TRUE(std::filesystem::exists(folder / "liver_healthy" / "stability.lloyd.h5"));
}

/// CLI11 gives all words behind a list to it.
TEST(CommandLine, BodiesMayStandBehindAList) {
    const std::string load_case = " --load-case " LIVERMARK_SOURCE_DIR "/tests/python/beam_release.toml";
    const auto same = [](const std::string &before, const std::string &behind) {
        const auto expected = livermark(before), found = livermark(behind);
        EXPECT_EQ(expected.status, 0) << expected.output;
        EXPECT_EQ(found.output, expected.output) << behind;
    };
    const auto folder = scratch_folder();
    const auto beam = " " LIVERMARK_SOURCE_DIR "/meshes/beam.toml";
    const auto rest = load_case + " --no-observed --output " + folder.string();
    same("stability" + std::string(beam) + " --integrator symplectic_euler heun" + rest,
         "stability --integrator symplectic_euler heun" + std::string(beam) + rest);
    same("stability beam --damping-frequencies 1 10 --integrator heun" + rest,
         "stability --integrator heun --damping-frequencies 1 10 beam" + rest);
    // What is no body and no path is a name of the list.
    const auto refused = livermark("stability --integrator heun symplectic_euler haun beam" + rest);
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.output.find("no integrator 'haun'"), std::string::npos) << refused.output;
}

TEST(CommandLine, TakesWordsInUpperCase) {
    EXPECT_EQ(livermark("list MODELS").output, livermark("list models").output);
    const auto refused = livermark("arena --precision DOUBLE --method nobody");
    EXPECT_NE(refused.output.find("no method 'nobody'"), std::string::npos) << refused.output;
}

} // namespace
} // namespace livermark
