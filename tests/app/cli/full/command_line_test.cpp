#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <numbers>
#include <string>
#include <unistd.h>
#include <utility>

#include "core/support/files.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

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
        tests::expect_outcome(outcome, 2, {"--output: the name is empty; give one, or leave the option out"});
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
    tests::expect_outcome(done, 0, {"box: a mesh of about 140 tetrahedra"});
    EXPECT_TRUE(std::filesystem::exists(folder / "new" / "folder" / "box.h5"));
}

TEST(CommandLine, ListsPublicExperimentsWithLicencesAndDigests) {
    const auto folder = scratch_folder();
    std::filesystem::create_directories(folder / "truth_cube");
    std::ofstream(folder / "truth_cube" / "uniaxial_positions.csv") << "nothing\n";
    const auto outcome = livermark("experiment --list --data " + folder.string());
    tests::expect_outcome(outcome, 0,
                          {"truth_cube: Truth Cube", "github.com/simquest/opensurgsim", "licence: MIT",
                           "here: " + (folder / "truth_cube" / "uniaxial_positions.csv").string(),
                           "046207017370b11e910fffc5a83a85901a1392ca45510dbcbf54f4a6be89efab  truth_cube/uniaxial_",
                           "Data are looked for in:\n  " + folder.string()});
    tests::expect_outcome(livermark("experiment truth_cube --data " + folder.string()), 2,
                          {(folder / "truth_cube").string(), "there is no line i,j,k"});
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
    tests::expect_outcome(outcome, 0, {"fem_p1 [Hz]"});
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
    tests::expect_outcome(outcome, 0, {"| explicit_euler | none | - | - |"});
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
    tests::expect_outcome(refused, 2, {"no integrator 'haun'"});
}

TEST(CommandLine, TakesWordsInUpperCase) {
    EXPECT_EQ(livermark("list MODELS").output, livermark("list models").output);
    const auto refused = livermark("arena --tool GLUED --method nobody");
    EXPECT_NE(refused.output.find("no method 'nobody'"), std::string::npos) << refused.output;
}

namespace fs = std::filesystem;

/// Command of a bar that is pulled, in a folder.
std::string run_of_a_bar(const fs::path &folder) {
    tests::write_pull(folder);
    const auto place = folder.string();
    return LIVERMARK_BINARY " run --body " + place + "/bar.toml --load-case " + place +
           "/pull.toml --model lloyd --static --reference-on-mesh --jobs 1 --output " + place + "/runs";
}

/// A disk that is full, a stream that is closed, a reader that has gone: progress goes nowhere, and the run does not
/// mind.
TEST(StandardError, ThatCannotBeWrittenDoesNotEndARun) {
    const auto folder = tests::folder_with_bar("standard_error");
    const auto command = run_of_a_bar(folder);
    const auto status = (folder / "status").string();
    for (const auto &whole : {command + " 2>/dev/full; echo $? >" + status, command + " 2>&-; echo $? >" + status,
                              "( " + command + " 2>&1 >/dev/null; echo $? >" + status + " ) | true"}) {
        SCOPED_TRACE(whole);
        fs::remove_all(folder / "runs");
        fs::remove(status);
        tests::run_command("( " + whole + " )");
        std::ifstream stream(status);
        EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "0\n");
        EXPECT_TRUE(fs::exists(folder / "runs" / "bar" / "pull.h5"));
    }
}

void write_script(const fs::path &file, const std::string &text) {
    std::ofstream(file) << "#!/bin/sh\n" << text;
    fs::permissions(file, fs::perms::owner_all);
}

/// A build folder of a source tree, and a program `cmake` that stands for the true one.
/// @param cmake  what it does; `$2` is the build folder where it builds
fs::path build_folder(const std::string &name, const std::string &rules, const std::string &cmake) {
    const auto folder = fs::path(testing::TempDir()) / name;
    fs::remove_all(folder);
    fs::create_directories(folder / "tree" / "scripts");
    fs::create_directories(folder / "bin");
    fs::copy_file(LIVERMARK_BINARY, folder / "livermark");
    std::ofstream(folder / "tree" / "scripts" / "bootstrap") << "";
    std::ofstream(folder / "CMakeCache.txt") << "CMAKE_HOME_DIRECTORY:INTERNAL=" << (folder / "tree").string() << "\n";
    std::ofstream(folder / "build.ninja") << rules;
    write_script(folder / "bin" / "cmake", "echo \"cmake $*\"\n" + cmake);
    return folder;
}

tests::Outcome phantom_in(const fs::path &folder) {
    return tests::run_command(
        fmt::format("cd {0} && PATH={0}/bin:$PATH ./livermark mesh --phantom -o phantom.nii.gz", folder.string()));
}

TEST(SegmentProgram, IsBuiltWhereItIsMissingInABuildFolder) {
    const auto folder = build_folder("livermark_builds_segment", "build livermark-segment: link\n",
                                     "printf '#!/bin/sh\\necho \"$3\" is made\\n' > $2/livermark-segment\n"
                                     "chmod +x $2/livermark-segment\n");
    const auto outcome = phantom_in(folder);
    tests::expect_outcome(outcome, 0,
                          {"which is compiled now", "cmake --build " + folder.string() + " --target livermark-segment",
                           "phantom is made"});
    EXPECT_EQ(phantom_in(folder).output.find("cmake"), std::string::npos) << "it is built once";
}

TEST(SegmentProgram, ThatCannotBeBuiltIsNamedWithTheCommandThatInstallsToo) {
    for (const auto &[rules, why] : {std::pair{"", "needs ITK and CGAL, and they are not installed"},
                                     {"build livermark-segment: link\n", "could not be compiled"}}) {
        const auto outcome = phantom_in(build_folder("livermark_cannot_build_segment", rules, "exit 0\n"));
        tests::expect_outcome(outcome, 2, {why, "scripts/bootstrap --program --segmentation"});
    }
}

/// A program that was copied alone says how to build what segmentations need.
TEST(SegmentProgram, IsNamedWithTheCommandThatBuildsItWhereItIsMissing) {
    const auto folder = fs::path(testing::TempDir()) / "livermark_without_segment";
    fs::remove_all(folder);
    fs::create_directories(folder);
    fs::copy_file(LIVERMARK_BINARY, folder / "livermark");
    const auto outcome =
        tests::run_command(fmt::format("cd {0} && ./livermark mesh --phantom -o phantom.nii.gz", folder.string()));
    tests::expect_outcome(outcome, 2,
                          {"livermark-segment, which is not built here; build it with scripts/bootstrap --program "
                           "--segmentation"});
    EXPECT_FALSE(fs::exists(folder / "phantom.nii.gz"));
}

} // namespace
} // namespace livermark
