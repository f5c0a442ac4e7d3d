#include <cmath>
#include <gtest/gtest.h>

#include "core/support/files.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/experiment.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_experiment.hpp"

namespace livermark::results {
namespace {

using ExperimentFile = tests::ResultFolder;

bool same(double a, double b) {
    return a == b || (std::isnan(a) && std::isnan(b));
}

TEST_F(ExperimentFile, KeepsAllThatWasWritten) {
    const auto written = tests::sample_experiment();
    write_experiment(path_, written);
    EXPECT_EQ(kind_of_file(path_), FileKind::experiment);
    const auto read = read_experiment(path_);
    EXPECT_EQ(read.name, written.name);
    EXPECT_EQ(read.title, written.title);
    EXPECT_EQ(read.source, written.source);
    EXPECT_EQ(read.assumptions, written.assumptions);
    EXPECT_EQ(read.reference, written.reference);
    EXPECT_EQ(read.markers, written.markers);
    EXPECT_EQ(read.drives, written.drives);
    EXPECT_EQ(read.positions, written.positions);
    EXPECT_EQ(read.points, written.points);
    EXPECT_EQ(read.boundary, written.boundary);
    EXPECT_EQ(read.runs, written.runs);
    ASSERT_EQ(read.states.size(), written.states.size());
    for (std::size_t s = 0; s < read.states.size(); ++s) {
        const auto &a = read.states[s], &b = written.states[s];
        EXPECT_EQ(a.name, b.name);
        EXPECT_EQ(a.deformed, b.deformed);
        for (const auto member :
             {&ExperimentState::noise, &ExperimentState::no_motion, &ExperimentState::rigid_motion,
              &ExperimentState::straight_line, &ExperimentState::fit_residual, &ExperimentState::reference_uncertainty})
            EXPECT_TRUE(same(a.*member, b.*member)) << s;
        ASSERT_EQ(a.displacement.size(), b.displacement.size());
        for (std::size_t k = 0; k < a.displacement.size(); ++k)
            EXPECT_TRUE(same(a.displacement[k].x(), b.displacement[k].x()));
    }
}

TEST_F(ExperimentFile, IsShownOnThePage) {
    write_experiment(path_, tests::sample_experiment());
    EXPECT_TRUE(is_shown_on_page(path_));
}

TEST_F(ExperimentFile, KeepsHowABodyRangDown) {
    const auto written = tests::sample_experiment();
    write_experiment(path_, written);
    const auto read = read_experiment(path_);
    EXPECT_EQ(read.damping_from, written.damping_from);
    ASSERT_EQ(read.ring_downs.size(), 1u);
    const auto &a = read.ring_downs.front(), &b = written.ring_downs.front();
    EXPECT_EQ(a.state, b.state);
    EXPECT_EQ(a.displacement, b.displacement);
    EXPECT_EQ(a.swings, b.swings);
    for (const auto member :
         {&RingDownResult::interval, &RingDownResult::frequency, &RingDownResult::frequency_uncertainty,
          &RingDownResult::damping_ratio, &RingDownResult::damping_uncertainty, &RingDownResult::swing_noise,
          &RingDownResult::noise, &RingDownResult::no_motion, &RingDownResult::rigid_motion})
        EXPECT_EQ(a.*member, b.*member);
    ASSERT_EQ(a.runs.size(), 2u);
    for (std::size_t r = 0; r < a.runs.size(); ++r) {
        EXPECT_EQ(a.runs[r].model, b.runs[r].model);
        EXPECT_EQ(a.runs[r].status, b.runs[r].status);
        EXPECT_EQ(a.runs[r].message, b.runs[r].message);
        EXPECT_EQ(a.runs[r].integrator, b.runs[r].integrator);
        EXPECT_EQ(a.runs[r].tetrahedra, b.runs[r].tetrahedra);
        EXPECT_EQ(a.runs[r].damping.beta, b.runs[r].damping.beta);
        EXPECT_EQ(a.runs[r].swings, b.runs[r].swings);
        EXPECT_EQ(a.runs[r].displacement, b.runs[r].displacement);
        for (const auto member :
             {&RingDownRun::time_step, &RingDownRun::frequency, &RingDownRun::damping_ratio, &RingDownRun::swing_error,
              &RingDownRun::error, &RingDownRun::start_error, &RingDownRun::seconds})
            EXPECT_TRUE(same(a.runs[r].*member, b.runs[r].*member)) << r;
    }
}

TEST_F(ExperimentFile, WithoutRingDownsIsThatOfAnOlderProgram) {
    auto written = tests::sample_experiment();
    written.ring_downs.clear();
    write_experiment(path_, written);
    EXPECT_TRUE(read_experiment(path_).ring_downs.empty());
    EXPECT_FALSE(hdf5::InputFile(path_).has("/experiment/ring_downs"));
}

TEST_F(ExperimentFile, WithFewerRecordsOfARunThanWereMeasuredIsRefused) {
    auto written = tests::sample_experiment();
    for (auto &run : written.ring_downs.front().runs)
        run.displacement.resize(20);
    written.ring_downs.front().displacement.resize(20);
    write_experiment(path_, written);
    EXPECT_EQ(read_experiment(path_).ring_downs.front().num_records(5), 4);
    written.ring_downs.front().displacement.resize(40);
    write_experiment(path_, written);
    tests::expect_input_error([&] { read_experiment(path_); },
                              {path_.string(), "/experiment/ring_downs/0/runs/displacement"});
}

TEST(RingDownTable, HasModelsThatAreLostLast) {
    const auto layout = ring_down_table(tests::sample_experiment());
    ASSERT_EQ(layout.rows.size(), 6u);
    EXPECT_EQ(layout.rows[0], (std::vector<std::string>{"much", "measured", "", "4.00", "", "0.050", "", "", ""}));
    EXPECT_EQ(layout.rows[1][4], "2.5"); // percent of the frequency
    EXPECT_EQ(layout.rows[4][1], "springs");
    EXPECT_EQ(layout.rows[4][4], "+5.0");
    EXPECT_EQ(layout.rows[5][1], "lost (diverged)");
    EXPECT_EQ(layout.rows[5][7], "-");
    EXPECT_NE(ring_down_note(tests::sample_experiment()).find("on much alone"), std::string::npos);
    auto without = tests::sample_experiment();
    without.ring_downs.clear();
    EXPECT_TRUE(ring_down_table(without).rows.empty());
    EXPECT_EQ(ring_down_note(without), "");
}

TEST_F(ExperimentFile, OfAnotherKindIsRefused) {
    hdf5::OutputFile file;
    file.group("/experiment");
    support::write_whole(path_, file.image());
    tests::expect_input_error([&] { read_experiment(path_); }, {path_.string(), "schema_version"});
}

TEST_F(ExperimentFile, WithAStateThatIsNotThereIsRefused) {
    auto written = tests::sample_experiment();
    written.runs.back().state = 2;
    write_experiment(path_, written);
    tests::expect_input_error([&] { read_experiment(path_); }, {path_.string(), "/experiment/runs/state"});
}

TEST(ExperimentTable, HasModelsWithoutASolutionLast) {
    const auto layout = experiment_table(tests::sample_experiment());
    ASSERT_EQ(layout.columns.size(), 5u);
    EXPECT_EQ(layout.rows.back().front(), "springs");
    EXPECT_EQ(layout.rows.back()[3], "0.20 (not_converged)");
    EXPECT_EQ(layout.rows.front()[2], "0.10"); // the noise
    for (const auto &row : layout.rows)
        EXPECT_EQ(row.size(), layout.columns.size());
}

TEST(MarkerError, IsOverMarkersThatDriveNothingAndWereSeen) {
    const auto result = tests::sample_experiment();
    auto displacement = result.states.front().displacement;
    displacement[3].x() = 1.0; // drives the top
    EXPECT_EQ(marker_error(result, displacement, result.states.front().displacement).root_mean_square, 0.0);
    displacement[1].x() = 0.004;
    const auto all = marker_error(result, displacement, result.states.front().displacement);
    EXPECT_NEAR(all.root_mean_square, 0.002, 1e-15);
    EXPECT_NEAR(all.worst, 0.004, 1e-15);
    displacement[0].x() = 1.0; // not seen in the second state
    EXPECT_NEAR(marker_error(result, displacement, result.states.back().displacement).root_mean_square,
                0.004 / std::sqrt(3.0), 1e-15);
}

} // namespace
} // namespace livermark::results
