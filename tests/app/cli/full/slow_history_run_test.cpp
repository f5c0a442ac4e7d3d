#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

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
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("Tissue that relaxes"), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find("left [%]"), std::string::npos) << outcome.output;
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
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("heat [mJ]"), std::string::npos) << outcome.output;
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
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("slow history before the release"), std::string::npos) << outcome.output;
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

TEST(SlowHistoryRun, RefusesNonsenseInOneSentence) {
    const auto folder = tests::folder_with_bar("slow_nonsense", 0.03);
    const auto outcome = run_slow_push(folder, "press = -1.0\n");
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_NE(outcome.output.find("positive time"), std::string::npos) << outcome.output;
}

} // namespace
} // namespace livermark
