#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <unistd.h>

#include "core/support/files.hpp"
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

/// Every option that names a place to write to, of every command.
TEST(CommandLine, RefusesPlacesWithoutAName) {
    for (const auto *arguments : {"run", "modes", "needle", "cut beam --blade 0 0 0 0 1 0 1 1 0 1 0 0", "arena",
                                  "experiment", "sensitivity", "cohort --bodies 2", "stability", "report .",
                                  "score beam beam_bend x.csv", "export beam beam_bend", "advise beam", "mesh liver",
                                  "mesh box --size 1 1 1 --edge 1", "mesh cut beam --region solid", "mesh --phantom"}) {
        const auto outcome = livermark(std::string(arguments) + " --output ''");
        EXPECT_EQ(outcome.status, 2) << arguments << '\n' << outcome.output;
        EXPECT_NE(outcome.output.find("--output: the name is empty; give one, or leave the option out"),
                  std::string::npos)
            << arguments << '\n'
            << outcome.output;
    }
}

/// Two runs with other models would write the same file, and one result would be lost.
TEST(CommandLine, RefusesToWriteWhatAnotherProcessIsAboutToWrite) {
    const auto folder = scratch_folder();
    const auto modes = "modes beam --model lloyd --count 1 --load-case beam_bend --output " + (folder / "out").string();
    std::filesystem::create_directories(folder / "out" / "beam");
    {
        const support::FileClaim other(folder / "out" / "beam" / "modes.beam_bend.h5");
        const auto refused = livermark(modes);
        EXPECT_EQ(refused.status, 2) << refused.output;
        EXPECT_NE(refused.output.find(fmt::format("(process {}) is about to write this file", getpid())),
                  std::string::npos)
            << refused.output;
        const auto run = livermark("run beam --model lloyd --reference-on-mesh --load-case beam_bend --output " +
                                   (folder / "out").string()); // another file
        EXPECT_EQ(run.status, 0) << run.output;
        const support::FileClaim claim_of_run(folder / "out" / "beam" / "beam_bend.h5");
        EXPECT_EQ(livermark("run beam --model van_gelder --reference-on-mesh --load-case beam_bend --output " +
                            (folder / "out").string())
                      .status,
                  2);
    }
    EXPECT_EQ(livermark(modes).status, 0);
    EXPECT_FALSE(std::filesystem::exists(folder / "out" / "beam" / ".livermark.lock"));
}

TEST(CommandLine, LeavesNoFolderOfARefusedExperiment) {
    const auto folder = scratch_folder();
    std::ofstream(folder / "box.toml")
        << "title = \"t\"\nsource = \"me\"\nmarkers = \"box.csv\"\nunit = \"mm\"\n[body]\n"
           "box = { size = [0.06, 0.03, 0.03], edge_length = 0.015 }\n[material]\n"
           "density = 1000.0\nyoung_modulus = 5000.0\npoisson_ratio = 0.45\n"
           "source = \"x\"\n[[state]]\nname = \"s\"\nregime = \"small\"\n"
           "acceleration = [0.0, 0.0, -1.0]\n[[state.condition]]\npatch = \"x_min\"\n"
           "displacement = [0.0, 0.0, 0.0]\n";
    std::ofstream(folder / "box.csv") << "marker,drives,x,y,z,s_x,s_y,s_z\na,,60,0,0,60,0,-0.1\nb,,60,30,0,60,30,-0.1\n"
                                         "c,,60,0,30,60,0,29.9\n";
    const auto experiment = "experiment " + (folder / "box.toml").string() + " --output " +
                            (folder / "new" / "folder").string() + " --reference-on-mesh --model ";
    const auto refused = livermark(experiment + "fem_p1_neo_hookean"); // of the other regime
    EXPECT_EQ(refused.status, 2) << refused.output;
    EXPECT_FALSE(std::filesystem::exists(folder / "new")) << refused.output;
    const auto done = livermark(experiment + "fem_p1");
    EXPECT_EQ(done.status, 0) << done.output;
    EXPECT_NE(done.output.find("box: a mesh of about 140 tetrahedra"), std::string::npos) << done.output;
    EXPECT_TRUE(std::filesystem::exists(folder / "new" / "folder" / "box.h5"));
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
    const auto refused = livermark("arena --tool GLUED --method nobody");
    EXPECT_NE(refused.output.find("no method 'nobody'"), std::string::npos) << refused.output;
}

} // namespace
} // namespace livermark
