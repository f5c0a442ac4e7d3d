#include <cmath>
#include <gtest/gtest.h>

#include "results/hdf5/file_kind.hpp"
#include "results/hdf5/files/experiment_file.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/tables/studies/experiment_table.hpp"
#include "support/whole_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/sample_experiment.hpp"

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
