#include <algorithm>
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
tests::Outcome run_slow_push(const fs::path &folder, const std::string &history, const std::string &options = "") {
    std::ofstream(folder / "push.toml")
        << "title = \"push\"\n[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n"
           "[[condition]]\nname = \"plate\"\npatch = \"x_max\"\npush = 0.001\n[history]\nrelaxation = "
           "\"liver_perfused\"\n"
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
