#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/child.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

/// Elements with displacements alone, mixed ones, and springs with and without a volume term: all end at the largest
/// ratio that is let in, in linear elasticity and beyond.
TEST(NearlyIncompressible, BodiesEndAtTheLargestRatio) {
    const auto folder = tests::folder_with_bar("nearly_incompressible", 0.015);
    for (const auto &[regime, models] :
         {std::pair{"small",
                    std::vector<std::string>{"fem_p1", "fem_p2", "fem_p2p1", "lloyd", "patch_nodal_volume",
                                             "van_gelder_tetrahedral_volume", "nodal_springs", "nodal_neo_hookean"}},
          {"large", {"fem_p1_neo_hookean", "fem_p2_neo_hookean", "fem_p2p1_neo_hookean", "nodal_neo_hookean"}}}) {
        SCOPED_TRACE(regime);
        tests::write_pull(folder, "pull", 10.0, fmt::format("regime = \"{}\"\n", regime));
        std::vector<std::string> words{LIVERMARK_BINARY, "run",
                                       "--body",         (folder / "bar.toml").string(),
                                       "--load-case",    (folder / "pull.toml").string()};
        for (const auto &word :
             {std::string("--static"), std::string("--reference-on-mesh"), std::string("--jobs"), std::string("1"),
              std::string("--output"), (folder / "runs").string(), std::string("--poisson"),
              std::to_string(core::largest_poisson_ratio), std::string("--model")})
            words.push_back(word);
        words.insert(words.end(), models.begin(), models.end());
        const auto start = std::chrono::steady_clock::now();
        const auto end = tests::run_child(
            words, {.killed_when = [=] { return std::chrono::steady_clock::now() - start > std::chrono::minutes(3); }});
        EXPECT_EQ(end.signal, 0) << end.output << end.errors;
        EXPECT_NE(end.output.find("nodal_neo_hookean"), std::string::npos) << end.output << end.errors;
    }
}

namespace fs = std::filesystem;

/// A bar that is held at one end, and pushed in at the other.
tests::Outcome run_slow_push(const fs::path &folder, const std::string &history, const std::string &options = "",
                             const std::string &load = "push = 0.001") {
    std::ofstream(folder / "push.toml")
        << "title = \"push\"\n[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n"
           "[[condition]]\nname = \"plate\"\npatch = \"x_max\"\n"
        << load << "\n[history]\nrelaxation = \"liver_perfused\"\n"
        << history;
    return tests::livermark(fmt::format("run --body {0}/bar.toml --load-case {0}/push.toml --model fem_p1 --jobs 1 "
                                        "--reference-on-mesh --output {0}/runs {1}",
                                        folder.string(), options));
}

TEST(SlowHistoryRun, StoresAndPrintsTheForceOverTime) {
    const auto folder = tests::folder_with_bar("slow_push", 0.03);
    const auto outcome = run_slow_push(folder, "press = 1.0\nhold = 60.0\n");
    tests::expect_outcome(outcome, 0, {"Tissue that relaxes", "left [%]"});
    const auto result = results::read_result(folder / "runs" / "bar" / "push.h5");
    const auto &history = result.problem.load_case.slow_history.value();
    EXPECT_EQ(history.relaxation.name, "liver_perfused");
    for (const auto &model : result.models) {
        ASSERT_EQ(model.solution.path.size(), history.times.size()) << model.name;
        const auto force = [&](int k) { return -model.solution.path[k].reaction.back().x(); };
        EXPECT_EQ(force(0), 0.0);
        for (int k = 11; k < history.num_records(); ++k) {
            EXPECT_LT(force(k), force(k - 1)) << model.name << " at " << history.times[k] << " s";
            EXPECT_GT(force(k), 0.3 * force(10));
        }
    }
    const auto p1 = std::ranges::find(result.models, "fem_p1", &results::ModelResult::name);
    ASSERT_NE(p1, result.models.end());
    const auto &slow = p1->comparison.value().slow.value();
    EXPECT_GT(slow.worst_error, slow.median_error);
    EXPECT_LT(slow.worst_error, 0.5);
}

TEST(SlowHistoryRun, LosesEnergyInACycle) {
    const auto folder = tests::folder_with_bar("slow_cycles", 0.03);
    const auto outcome = run_slow_push(folder, "frequency = 1.0\ncycles = 2\n");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    const auto result = results::read_result(folder / "runs" / "bar" / "push.h5");
    for (const auto &model : result.models) {
        const double lost = core::lost_energy(result.problem.load_case.slow_history.value(), model.solution);
        EXPECT_GT(lost, 0.01 * model.solution.strain_energy) << model.name;
        EXPECT_LT(lost, model.solution.strain_energy) << model.name;
    }
}

/// A rod that is stretched evenly has the same strain in every model, so that all turn as much into heat: the work of
/// springs is summed in longer steps, and is not heat.
TEST(SlowHistoryRun, HasTheHeatOfAnEvenStretch) {
    const auto folder = tests::folder_with_bar("slow_heat", 0.03);
    std::ofstream(folder / "cycles.toml")
        << "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, \"free\", \"free\"]\n"
           "[[condition]]\npatch = \"y_min\"\ndisplacement = [\"free\", 0.0, \"free\"]\n"
           "[[condition]]\npatch = \"z_min\"\ndisplacement = [\"free\", \"free\", 0.0]\n"
           "[[condition]]\nname = \"pull\"\npatch = \"x_max\"\ndisplacement = [0.0006, \"free\", \"free\"]\n"
           "[history]\nrelaxation = { moduli = [0.4, 0.2], times = [0.7, 8.0] }\nfrequency = 0.5\ncycles = 3\n";
    const auto outcome = tests::livermark(fmt::format("run --body {0}/bar.toml --load-case {0}/cycles.toml --model "
                                                      "fem_p1 nodal_springs --jobs 1 --reference-on-mesh --output "
                                                      "{0}/runs",
                                                      folder.string()));
    tests::expect_outcome(outcome, 0, {"heat [mJ]"});
    const auto result = results::read_result(folder / "runs" / "bar" / "cycles.h5");
    const auto &history = result.problem.load_case.slow_history.value();
    const double expected_loss = core::lost_energy(history, result.models.front().solution);
    EXPECT_GT(expected_loss, 1e-8);
    for (const auto &model : result.models) {
        EXPECT_NEAR(core::lost_energy(history, model.solution), expected_loss, 2e-3 * expected_loss) << model.name;
        if (model.comparison) {
            EXPECT_LT(std::abs(model.comparison->slow.value().lost_energy), 2e-3) << model.name;
        }
    }
}

TEST(SlowHistoryRun, LetsGoAndComparesTheMotion) {
    const auto folder = tests::folder_with_bar("slow_release", 0.03);
    const std::string release = "press = 1.0\nhold = 5.0\n[release]\nduration = 0.3\noutput_interval = 0.004\n"
                                "alpha = 1.0\nbeta = 0.001\n[[probe]]\nname = \"end\"\npatch = \"x_max\"\n";
    const auto outcome =
        run_slow_push(folder, release, "--model nodal_springs fem_p2p1 --poisson 0.45", "traction = [0.0, 0.0, 2.0]");
    tests::expect_outcome(outcome, 0, {"slow history before the release"});
    const auto result = results::read_result(folder / "runs" / "poisson_0.45" / "bar" / "push.h5");
    for (const auto &model : result.models) {
        const bool moves = model.name != "fem_p2p1"; // which has pressures at this ratio
        EXPECT_EQ(model.solution.history.has_value(), moves) << model.name;
        if (!moves || model.name == "fem_p2")
            continue;
        ASSERT_TRUE(model.comparison && model.comparison->history) << model.name;
        EXPECT_EQ(model.comparison->history->reference, "fem_p2");
        EXPECT_LT(model.comparison->history->relative_l2, 1.0) << model.name;
    }
}

TEST(SlowHistoryRun, SaysWhichModelsTakeNoPart) {
    const auto folder = tests::folder_with_bar("slow_no_part", 0.03);
    const auto outcome = run_slow_push(folder, "press = 1.0\n", "--model xpbd_springs");
    EXPECT_NE(outcome.output.find("are left out"), std::string::npos) << outcome.output;
}

TEST(TimeSpent, IsThatOfTheStages) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "livermark_time_spent";
    const auto outcome = tests::livermark("run --body beam --load-case beam_stretch --model lloyd --reference-on-mesh "
                                          "--tables "
                                          "--output " +
                                          folder.string());
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto at = outcome.output.find("Time spent: ");
    ASSERT_NE(at, std::string::npos) << outcome.output;
    std::istringstream words(outcome.output.substr(at + 12));
    double total = 0.0;
    words >> total;
    EXPECT_GT(total, 0.0);

    double sum = 0.0;
    std::string line;
    while (std::getline(words, line))
        if (std::istringstream row(line); line.starts_with("fem_p2p1 ") || line.starts_with("fem_p2 ") ||
                                          line.starts_with("fem_p1 ") || line.starts_with("lloyd ")) {
            std::string model;
            double seconds = 0.0;
            row >> model >> seconds;
            sum += seconds;
        }
    EXPECT_GT(sum, 0.3 * total) << outcome.output;
    EXPECT_LE(sum, total + 0.5) << outcome.output; // each is rounded to a tenth
}

/// @param more  lines of the load case
fs::path folder_with_pull(const std::string &suite, double traction, const std::string &more = "") {
    const auto folder = tests::folder_with_bar(suite, 0.03);
    tests::write_pull(folder, "pull", traction, more);
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
        EXPECT_EQ(tests::count(both.output, "Errors are against"), 2u) << both.output;
        const auto end = both.output.find("Errors are against fem_p2p1,");
        const auto first = both.output.substr(0, end), second = both.output.substr(end);
        EXPECT_EQ(tests::count(first, "lloyd "), 1u) << both.output;
        EXPECT_EQ(tests::count(second, "lloyd "), 1u) << both.output;
        EXPECT_EQ(tests::count(second, "fem_p2p1_refined"), 0u) << both.output;
    }
}

TEST(TablesOfRuns, NameALoadThatLeavesItsRegimeAndCallNothingOk) {
    const auto outcome = run_pull(folder_with_pull("out_of_regime", 300.0), "--reference-on-mesh");
    tests::expect_outcome(outcome, 0, {"bar, nu 0.3, pull moves ", " mm where 1 mm were meant", "out of regime"});
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
    tests::expect_outcome(outcome, 1, {"livermark: failed: bar / pull: cannot be scaled to its target"});
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
