#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "results/result_file.hpp"
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

std::string written(const std::filesystem::path &file, const std::string &text) {
    std::ofstream(file) << text;
    return file.string();
}

TEST(CommandLine, HelpAndVersionAreNoErrors) {
    for (const char *arguments : {"--help", "run --help", "list --help", "mesh --help", "mesh liver --help",
                                  "mesh check --help", "modes --help", "calibrate --help", "stability --help",
                                  "histories --help", "parameters --help", "table --help", "--version"}) {
        const auto outcome = livermark(arguments);
        EXPECT_EQ(outcome.status, 0) << arguments << "\n" << outcome.output;
        EXPECT_FALSE(outcome.output.empty());
    }
}

TEST(CommandLine, ListsWhatShips) {
    EXPECT_NE(livermark("list bodies").output.find("liver_healthy"), std::string::npos);
    EXPECT_NE(livermark("list load-cases").output.find("palpation"), std::string::npos);
    EXPECT_NE(livermark("list models").output.find("fem_p2"), std::string::npos);
    EXPECT_NE(livermark("list spring-laws").output.find("lloyd"), std::string::npos);
}

struct BadArguments {
    const char *arguments;
    const char *message;
};

/// Status 2, and a message that names the remedy.
TEST(CommandLine, RefusesBadArgumentsWithStatusTwo) {
    const auto folder = scratch_folder();
    const auto output = " --output " + (folder / "runs").string();
    for (const auto &[arguments, message] : {
             BadArguments{"", "subcommand is required"},
             {"rnu", "did you mean 'run'?"},
             {"list", "what is required"},
             {"list model", "not in {"},
             {"run --body liver_healty", "did you mean 'liver_healthy'?"},
             {"run --load-case palpatoin", "did you mean 'palpation'?"},
             {"run --model loyd", "did you mean 'lloyd'?"},
             {"run --model xyzzyxyzzy", "known are: biquadratic_springs, fem_p1"},
             {"run --body liver_healthy --body liver_healthy", "asked for twice"},
             {"table --kind overviev", "overviev not in {"},
             {"table /nowhere/runs", "/nowhere/runs"},
             {"run --body /nowhere/body.toml", "/nowhere/body.toml"},
             {"run --young soft", "--young"},
             {"run --young -5", "Young's modulus is -5 Pa; it has to be positive"},
             {"run --young nan", "has to be positive"},
             {"run --poisson 0.5", "has to lie between -1 and 0.5"},
             {"modes liver_healty", "did you mean 'liver_healthy'?"},
             {"modes --model fem_p2p1", "there is no model with modes 'fem_p2p1'"},
             {"modes --model fem_p1 --model fem_p1", "asked for twice"},
             {"modes --load-case tracton", "did you mean 'traction'?"},
             {"modes --count 0", "--count"},
             {"stability --law loyd", "did you mean 'lloyd'?"},
             {"stability --integrator rk4", "there is no integrator 'rk4'"},
             {"stability --integrator heun --integrator heun", "asked for twice"},
             {"stability --damping-ratio nan", "has to be a finite number"},
             {"stability --damping-frequencies 0 10", "--damping-frequencies"},
             {"histories --load-case traction", "lets nothing go"},
             {"histories --time-step 1e-5 --duration 11", "more than a million steps"},
             {"histories --duration nan", "more than a million steps"},
             {"run --poisson nan", "has to lie between -1 and 0.5"},
             {"calibrate liver_healty", "did you mean 'liver_healthy'?"},
             {"calibrate liver_healthy --law loyd", "did you mean 'lloyd'?"},
             {"calibrate liver_healthy --iterations 30", "takes a multiple of 20"},
             {"calibrate liver_healthy --loads 3", "--loads"},
             {"calibrate liver_healthy --held nowhere", "has no patch 'nowhere'"},
             {"run --fem-solver magic", "--fem-solver"},
         }) {
        const auto outcome = livermark(arguments + (std::string(arguments).starts_with("run ") ? output : ""));
        EXPECT_EQ(outcome.status, 2) << arguments << "\n" << outcome.output;
        EXPECT_NE(outcome.output.find(message), std::string::npos) << arguments << "\n" << outcome.output;
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "runs")) << "bad input left something behind";
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

TEST(CommandLine, RefusesAnOutputFolderThatCannotBe) {
    const auto file = written(scratch_folder() / "a_file", "in the way");
    const auto outcome = livermark("run --output " + file);
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_NE(outcome.output.find("choose another --output"), std::string::npos) << outcome.output;
}

TEST(CommandLine, RefusesABodyWithFaultsAndLeavesEarlierResultsAlone) {
    const auto folder = scratch_folder();
    const auto results = folder / "runs";
    std::filesystem::create_directories(results / "body");
    const auto earlier = written(results / "body" / "palpation.h5", "earlier result");
    const auto with_body = [&](const std::string &toml, const std::string &msh) {
        written(folder / "body.msh", msh);
        return livermark("run --body " + written(folder / "body.toml", toml) + " --output " + results.string());
    };
    const std::string toml = "title = \"t\"\nmesh = \"body.msh\"\n[regions.a]\ndensity = 1000\nyoung_modulus = 5000\n"
                             "poisson_ratio = 0.45\nsource = \"s\"\n";
    const std::string msh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"a\"\n$EndPhysicalNames\n"
                            "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
                            "$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n";
    const auto replaced = [](std::string text, const std::string &from, const std::string &to) {
        return text.replace(text.find(from), from.size(), to);
    };
    const std::array<std::array<std::string, 3>, 11> cases{{
        {toml, msh, "the body has no patch"},
        {toml, replaced(msh, "1 2 3 4", "2 1 3 4"), "tetrahedron 1 is inverted"},
        {toml, replaced(msh, "1 0 0\n3", "1 nan 0\n3"), "not finite"},
        {toml, msh.substr(0, 110), "ends too early"},
        {replaced(toml, "[regions.a]", "[regions.b]"), msh, "no region 'b'"},
        {replaced(toml, "0.45", "0.5"), msh, "Poisson's ratio is 0.5"},
        {replaced(toml, "1000", "-1"), msh, "the density is -1 kg/m^3"},
        {replaced(toml, "5000", "0"), msh, "Young's modulus is 0 Pa"},
        {replaced(toml, "density", "densty"), msh, "did you mean 'density'?"},
        {replaced(toml, "body.msh", "other.msh"), msh, "other.msh: cannot be read"},
        {"regions = 3\n", msh, "'title' is missing"},
    }};
    for (const auto &[bad_toml, bad_msh, message] : cases) {
        const auto outcome = with_body(bad_toml, bad_msh);
        EXPECT_EQ(outcome.status, 2) << message << "\n" << outcome.output;
        EXPECT_NE(outcome.output.find(message), std::string::npos) << message << "\n" << outcome.output;
        EXPECT_EQ(std::ranges::count(outcome.output, '\n'), 1) << "more than one sentence: " << outcome.output;
    }
    std::ifstream stream(earlier);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "earlier result");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(results / "body"), {}), 1);
}

} // namespace
} // namespace livermark
