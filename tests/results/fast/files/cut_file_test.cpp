#include "results/records/cut.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "results/records/result.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_cut.hpp"

namespace livermark::results {
namespace {

using CutFiles = tests::ResultFolder;

TEST_F(CutFiles, HoldWhatWasWritten) {
    auto written = tests::sample_cut();
    written.provenance = current_provenance("livermark cut");
    write_cut(path_, written);
    const auto read = read_cut_file(path_);
    EXPECT_EQ(read.provenance, written.provenance);
    EXPECT_EQ(read.blade, written.blade);
    EXPECT_EQ(read.toughness, 100.0);
    EXPECT_EQ(read.depth, written.depth);
    EXPECT_EQ(read.area, written.area);
    EXPECT_EQ(read.cut_seconds, written.cut_seconds);
    EXPECT_EQ(read.nodes, written.nodes);
    ASSERT_EQ(read.runs.size(), 2U);
    EXPECT_EQ(read.runs[1].model, "springs");
    EXPECT_EQ(read.runs[1].stored, written.runs[1].stored);
    EXPECT_EQ(read.runs[1].work, written.runs[1].work);
    EXPECT_EQ(read.runs[1].opening, written.runs[1].opening);
    EXPECT_EQ(read.runs[1].tool_stiffness, written.runs[1].tool_stiffness);
    EXPECT_EQ(read.runs[1].setup_seconds, written.runs[1].setup_seconds);
    EXPECT_EQ(read.runs[1].solve_seconds, written.runs[1].solve_seconds);
    EXPECT_TRUE(read.runs[0].critical_time_step.empty());
    EXPECT_EQ(read.runs[1].critical_time_step, written.runs[1].critical_time_step);
    EXPECT_EQ(read.regime, core::Regime::large);
    EXPECT_EQ(read.levels, written.levels);
    EXPECT_EQ(read.frame_interval, 0.02);
    EXPECT_EQ(read.frames_per_step, 5);
    EXPECT_EQ(read.motions, written.motions);
}

TEST_F(CutFiles, MayHoldNoMotionsAndNoFinerMeshes) {
    auto written = tests::sample_cut();
    written.motions.clear();
    written.levels.clear();
    write_cut(path_, written);
    EXPECT_TRUE(read_cut_file(path_).levels.empty());
    EXPECT_TRUE(read_cut_file(path_).motions.empty());
}

TEST_F(CutFiles, TellHowMotionsEndedBesideTheReference) {
    auto file = tests::sample_cut();
    file.levels.clear();
    const auto table = cut_motions_table(file);
    ASSERT_EQ(table.rows.size(), 2U);
    EXPECT_EQ(table.rows[0][0], "elements"); // of the smaller budget
    EXPECT_EQ(table.rows[0][2], "too slow");
    EXPECT_EQ(table.rows[1],
              (std::vector<std::string>{"springs", "4.00", "but for cuts", "12 x 1", "3.000", "50.0", "36.00", "20.0",
                                        "50.0", "opening", "50.00", "50.00", "2.00", "52.00"}));
}

TEST_F(CutFiles, RankMotionsOfABudgetByTheLargerError) {
    auto file = tests::sample_cut();
    const auto add = [&](const char *method, double opening, double stiffness, double frame_seconds) {
        auto motion = file.motions.front();
        motion.method = method;
        motion.budget = 0.01;
        motion.opening.back() = opening;
        motion.tool_stiffness.back() = stiffness;
        motion.frame_seconds = frame_seconds;
        motion.worst_frame_seconds = 1.1 * frame_seconds;
        file.motions.push_back(std::move(motion));
    };
    file.motions.clear();
    file.levels.clear();
    const double lost = std::nan("");
    add("lost", lost, lost, 0.001);
    add("slow", 0.002, 30.0, 0.02);              // exact, but too late
    add("opens well", 0.002, 36.0, 0.001);       // 20 % off at the tool
    add("opens less well", 0.0022, 30.0, 0.001); // 10 % off in the opening
    add("slow", 0.0025, 30.0, 0.001);            // the same method, in time
    const auto table = cut_motions_table(file);
    std::vector<std::vector<std::string>> found; // method, in time, larger, whose
    for (const auto &row : table.rows)
        found.push_back({row[0], row[2], row[8], row[9]});
    EXPECT_EQ(found, (std::vector<std::vector<std::string>>{{"opens less well", "yes", "10.0", "opening"},
                                                            {"opens well", "yes", "20.0", "tool"},
                                                            {"slow", "yes", "25.0", "opening"},
                                                            {"lost", "yes", "-", "-"}}));
    // Without a tool the opening alone counts.
    for (auto &stiffness : {&file.runs.front().tool_stiffness, &file.motions[2].tool_stiffness})
        stiffness->back() = lost;
    std::erase_if(file.motions, [](const CutMotion &motion) { return motion.method != "opens well"; });
    EXPECT_EQ(cut_motions_table(file).rows.front()[8], "0.0");
    EXPECT_EQ(cut_motions_table(file).rows.front()[9], "opening");
}

TEST_F(CutFiles, TellTheErrorOfTheReferenceFromThreeMeshes) {
    const auto file = tests::sample_cut();
    const auto table = cut_levels_table(file);
    ASSERT_EQ(table.rows.size(), 5U);
    EXPECT_EQ(table.rows[2], (std::vector<std::string>{"facets", "500", "2.00", "18.0", "2.600", "28.50", "12.0"}));
    const auto opening = file.in_the_end("facets", &CutLevel::opening);
    ASSERT_TRUE(opening);
    EXPECT_EQ(opening->value, 0.0026);
    EXPECT_NEAR(opening->error, 2e-4, 1e-12);                   // steps of 0.4 and 0.2 mm: as much again is to come
    EXPECT_FALSE(file.in_the_end("exact", &CutLevel::opening)); // two meshes say no order
    EXPECT_EQ(cut_levels_note(file), "facets: opening 2.600 +- 0.200 mm, tool 28.50 +- 0.50 N/m; on the coarsest of "
                                     "these meshes judge is off by -23.1 % and 5.3 %.\n");
}

TEST_F(CutFiles, CompareWithTheFinestMeshOfTheReference) {
    auto file = tests::sample_cut();
    const auto models = cut_models_table(file);
    ASSERT_EQ(models.rows.size(), 3U);
    EXPECT_EQ(models.rows[0], (std::vector<std::string>{"judge, refined (reference)", "2.600", "+- 7.7", "-", "-", "-",
                                                        "28.50", "+- 1.8", "-", "-", "-"}));
    EXPECT_EQ(models.rows[1][0], "judge"); // on the mesh of the models, which is off as well
    EXPECT_EQ(models.rows[1][2], "-23.1");
    EXPECT_EQ(models.rows[1][7], "5.3");
    EXPECT_EQ(models.rows[2][2], "15.4");
    EXPECT_EQ(models.rows[2][4], "-"); // finer meshes do not say what was released
    EXPECT_EQ(models.rows[2][7], "26.3");
    EXPECT_EQ(cut_motions_table(file).rows[1][5], "15.4");
    EXPECT_EQ(cut_judge_note(file), "Errors are against judge on the finest mesh, which is uncertain by 7.7 % in the "
                                    "opening and 1.8 % at the tool.\n");
    file.levels.erase(file.levels.begin()); // two meshes are not enough
    EXPECT_FALSE(file.judge_in_the_end().is_refined);
    EXPECT_EQ(cut_models_table(file).rows[0][0], "judge (reference)");
    EXPECT_EQ(cut_judge_note(file), "Errors are against judge on the mesh of the models, which has no error bar.\n");
}

TEST_F(CutFiles, TellTheStepsOfSpringsBeforeAndAfter) {
    auto file = tests::sample_cut();
    const std::vector<std::string> row{"springs", "2.820", "2.000", "0.470"};
    ASSERT_EQ(cut_steps_table(file).rows.size(), 1U); // of the model that has springs
    EXPECT_EQ(cut_steps_table(file).rows.front(), row);
    file.runs[1].critical_time_step.pop_back();
    EXPECT_EQ(cut_steps_table(file).rows.front().back(), "-"); // no exact cut
    file.runs.pop_back();
    EXPECT_TRUE(cut_steps_table(file).rows.empty());
}

TEST_F(CutFiles, AreRefusedWhereTheyCannotBe) {
    EXPECT_THROW(read_cut_file(directory_ / "none.h5"), support::InputError);
    auto wrong = tests::sample_cut();
    wrong.runs[1].work.pop_back();
    write_cut(path_, wrong);
    EXPECT_THROW(read_cut_file(path_), support::InputError);
    wrong = tests::sample_cut();
    wrong.area.pop_back();
    write_cut(path_, wrong);
    EXPECT_THROW(read_cut_file(path_), support::InputError);
}

TEST_F(CutFiles, SayWhatACutSetsFree) {
    const auto file = tests::sample_cut();
    EXPECT_NEAR(file.runs[0].released(1), 0.005, 1e-15);
    EXPECT_NEAR(file.release_rate(file.runs[0], 1), 25.0, 1e-10);
    EXPECT_TRUE(std::isnan(file.release_rate(file.runs[0], 2)));
    EXPECT_NEAR(file.tearing(2), 0.02, 1e-15);
    const auto steps = cut_table(file);
    ASSERT_EQ(steps.rows.size(), 3U);
    EXPECT_EQ(steps.rows[1], (std::vector<std::string>{"10.0", "2.00", "2.000", "15.000", "5.000", "25.000", "15.00",
                                                       "30.00", "250"}));
    EXPECT_EQ(steps.rows[2][5], "-");
    auto on_mesh = file;
    on_mesh.levels.clear();
    const auto models = cut_models_table(on_mesh);
    ASSERT_EQ(models.rows.size(), 2U);
    EXPECT_EQ(models.rows[0][0], "judge (reference)");
    EXPECT_EQ(models.rows[1], (std::vector<std::string>{"springs", "3.000", "50.0", "6.000", "20.0", "30.000", "36.00",
                                                        "20.0", "300", "300", "250"}));
    // Of the steps that have parted something, so not of the second.
    EXPECT_EQ(file.ready_seconds(file.runs[0]), std::vector<double>{1.25});
    EXPECT_EQ(file.equilibrium_seconds(file.runs[0]), std::vector<double>{2.0});
    EXPECT_NE(cut_note(file).find("0 of 1 steps"), std::string::npos) << cut_note(file);
    auto weaker = file;
    weaker.toughness = 20.0;
    EXPECT_NE(cut_note(weaker).find("1 of 1 steps"), std::string::npos) << cut_note(weaker);
}

} // namespace
} // namespace livermark::results
