#include "results/hdf5/cut_file.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "results/provenance.hpp"
#include "results/tables/studies/cut_table.hpp"
#include "support/input_error.hpp"
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
    EXPECT_EQ(read.frame_interval, 0.02);
    EXPECT_EQ(read.frames_per_step, 5);
    EXPECT_EQ(read.motions, written.motions);
}

TEST_F(CutFiles, MayHoldNoMotions) {
    auto written = tests::sample_cut();
    written.motions.clear();
    write_cut(path_, written);
    EXPECT_TRUE(read_cut_file(path_).motions.empty());
}

TEST_F(CutFiles, TellHowMotionsEndedBesideTheReference) {
    const auto table = cut_motions_table(tests::sample_cut());
    ASSERT_EQ(table.rows.size(), 2U);
    EXPECT_EQ(table.rows[0], (std::vector<std::string>{"springs", "4.00", "12 x 1", "3.000", "50.0", "36.00", "20.0",
                                                       "50.00", "50.00", "2.00", "52.00"}));
    EXPECT_EQ(table.rows[1][1], "1.00, needs 1.50");
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
    const auto models = cut_models_table(file);
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
