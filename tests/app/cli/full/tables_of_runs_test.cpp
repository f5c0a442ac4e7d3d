#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// A bar that is held at one end, and pulled at the other.
/// @param more  lines of the load case
fs::path folder_with_pull(const std::string &suite, double traction, const std::string &more = "") {
    const auto folder = tests::folder_with_bar(suite, 0.03);
    std::ofstream(folder / "pull.toml") << "title = \"pull\"\ntarget_peak_displacement = 0.001\n"
                                        << more << "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n"
                                        << fmt::format("[[condition]]\npatch = \"x_max\"\ntraction = [{}, 0.0, 0.0]\n",
                                                       traction);
    return folder;
}

tests::Outcome run_pull(const fs::path &folder, const std::string &options, const std::string &output = "runs") {
    return tests::livermark(fmt::format("run --body {0}/bar.toml --load-case {0}/pull.toml --model lloyd --jobs 1 "
                                        "--output {0}/{1} {2}",
                                        folder.string(), output, options));
}

bool has_part(const tests::Outcome &outcome, const std::string &part) {
    return outcome.output.find(part) != std::string::npos;
}

int count_parts(const std::string &text, const std::string &part) {
    int count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++count;
    return count;
}

TEST(TablesOfRuns, NameTheReferenceAndNeverMixTwo) {
    const auto folder = folder_with_pull("two_references", 20.0);
    const auto refined = run_pull(folder, "", "refined"), on_mesh = run_pull(folder, "--reference-on-mesh", "on_mesh");
    EXPECT_EQ(refined.status, 0) << refined.output;
    EXPECT_EQ(on_mesh.status, 0) << on_mesh.output;
    EXPECT_TRUE(has_part(refined, "Errors are against fem_p2p1_refined, which was solved on refined meshes"))
        << refined.output;
    EXPECT_TRUE(has_part(on_mesh, "Errors are against fem_p2p1, which was solved on the mesh of the models itself"))
        << on_mesh.output;
    for (const auto *const kind : {"models", "summary", "overview", "means", "medians"}) {
        const auto both =
            tests::livermark(fmt::format("table --kind {1} {0}/refined {0}/on_mesh", folder.string(), kind));
        EXPECT_EQ(both.status, 0) << both.output;
        EXPECT_EQ(count_parts(both.output, "Errors are against"), 2) << both.output;
        const auto end = both.output.find("Errors are against fem_p2p1,");
        const auto first = both.output.substr(0, end), second = both.output.substr(end);
        EXPECT_EQ(count_parts(first, "lloyd "), 1) << both.output;
        EXPECT_EQ(count_parts(second, "lloyd "), 1) << both.output;
        EXPECT_EQ(count_parts(second, "fem_p2p1_refined"), 0) << both.output;
    }
}

TEST(TablesOfRuns, NameALoadThatLeavesItsRegimeAndCallNothingOk) {
    const auto outcome = run_pull(folder_with_pull("out_of_regime", 300.0), "--reference-on-mesh");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(has_part(outcome, "bar, nu 0.3, pull moves ")) << outcome.output;
    EXPECT_TRUE(has_part(outcome, " mm where 1 mm were meant")) << outcome.output;
    EXPECT_TRUE(has_part(outcome, "out of regime")) << outcome.output;
    EXPECT_FALSE(has_part(outcome, "  ok ")) << outcome.output;
}

/// No factor makes a millimetre of nothing: all corners of the end that is pulled are held.
TEST(TablesOfRuns, AreNoneWhereEveryCaseFailsAndTheReasonIsSaid) {
    const auto folder = tests::folder_with_bar("all_failed", 0.03);
    meshes::write_msh(folder / "bar.msh", meshes::generate_box({0.09, 0.03, 0.03}, 0.03, meshes::BoxTopology::kuhn));
    std::ofstream(folder / "pull.toml")
        << "title = \"pull\"\ntarget_peak_displacement = 0.001\nscale_to_target = true\n[[condition]]\n"
           "patches = [\"x_min\", \"y_min\", \"y_max\", \"z_min\", \"z_max\"]\ndisplacement = [0.0, 0.0, 0.0]\n"
           "[[condition]]\npatch = \"x_max\"\ntraction = [1.0, 0.0, 0.0]\n";
    const auto outcome = run_pull(folder, "--reference-on-mesh");
    EXPECT_EQ(outcome.status, 1) << outcome.output;
    EXPECT_TRUE(has_part(outcome, "livermark: failed: bar / pull: cannot be scaled to its target")) << outcome.output;
    EXPECT_FALSE(has_part(outcome, "Errors are against")) << outcome.output;
}

TEST(TablesOfRuns, EndWithTheStepToTakeForEachModel) {
    const auto folder = folder_with_pull("step_to_take", 20.0);
    const auto outcome = tests::livermark(fmt::format("stability {0}/bar.toml --load-case {0}/pull.toml --model "
                                                      "nodal_neo_hookean lloyd --no-observed --output {0}/runs",
                                                      folder.string()));
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    for (const auto *const model : {"nodal_neo_hookean", "lloyd"}) {
        EXPECT_TRUE(has_part(outcome, fmt::format("bar, {}: take ", model))) << outcome.output;
        EXPECT_TRUE(fs::exists(folder / "runs" / "bar" / fmt::format("stability.{}.h5", model)));
    }
}

} // namespace
} // namespace livermark
