#include "results/records/arena.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <tuple>

#include "core/support/input_error.hpp"
#include "results/hdf5/references.hpp"
#include "results/hdf5/result_files.hpp"
#include "results/provenance.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_arena.hpp"
#include "tests/samples/tool_block.hpp"

namespace livermark::results {
namespace {

using ArenaFile = tests::ResultFolder;

TEST_F(ArenaFile, HoldsWhatWasWritten) {
    auto written = tests::sample_arena();
    written.provenance = current_provenance("livermark arena");
    write_arena(path_, written);
    EXPECT_EQ(kind_of_file(path_), FileKind::arena);
    const auto read = read_arena(path_);
    EXPECT_EQ(read.provenance, written.provenance);
    EXPECT_EQ(read.title, written.title);
    EXPECT_EQ(read.reference, written.reference);
    EXPECT_EQ(read.time, written.time);
    EXPECT_EQ(read.reference_force, written.reference_force);
    EXPECT_EQ(read.reference_errors, written.reference_errors);
    ASSERT_EQ(read.runs.size(), 2U);
    EXPECT_EQ(read.runs[0], written.runs[0]);
    EXPECT_EQ(read.runs[1].outcome, ArenaOutcome::diverged);
    EXPECT_EQ(read.runs[1].num_inverted, 7);
    EXPECT_EQ(read.tool, glued_tool);
    EXPECT_EQ(read.reference_pressed_force, 2.0);
    EXPECT_EQ(read.series, written.series);
    EXPECT_EQ(read.methods, written.methods);
}

TEST_F(ArenaFile, SaysHowStiffAMethodIsWithEachNumberOfIterations) {
    const auto table = arena_series(tests::sample_arena());
    ASSERT_EQ(table.rows.size(), 3U);
    EXPECT_EQ(table.rows[0].size(), table.columns.size());
    for (const auto &[row, iterations, error, stiffness] :
         {std::tuple(0, "1", "40.0", "-50.0"), std::tuple(2, "4", "10.0", "100.0")}) {
        EXPECT_EQ(table.rows[row][4], iterations);
        EXPECT_EQ(table.rows[row][5], error);
        EXPECT_EQ(table.rows[row][8], stiffness);
    }
    auto touched = tests::sample_arena();
    touched.reference_pressed_force = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(arena_series(touched).rows[0][8], "-");
}

TEST_F(ArenaFile, SaysWhatTheToolIs) {
    auto written = tests::sample_arena();
    EXPECT_EQ(tool_of(written), "the tool has hold of its place");
    written.tool = touching_tool;
    written.friction = 0.3;
    written.ball_radius = 0.012;
    written.reference.clear();
    write_arena(path_, written);
    const auto read = read_arena(path_);
    EXPECT_EQ(read.tool, touching_tool);
    EXPECT_EQ(read.friction, 0.3);
    EXPECT_EQ(read.ball_radius, 0.012);
    EXPECT_EQ(read.runs[0], written.runs[0]);
    EXPECT_EQ(tool_of(read), "the tool is a ball of 12 mm that touches, with a friction of 0.3");
    written.face = core::ToolFace::square;
    written.plate_size = 0.02;
    write_arena(path_, written);
    EXPECT_EQ(tool_of(read_arena(path_)), tool_of(written));
    EXPECT_NE(tool_of(written).find("a square plate of 20 mm"), std::string::npos) << tool_of(written);
    const auto table = arena_forces(read);
    ASSERT_EQ(table.rows.size(), 2U);
    EXPECT_EQ(table.rows.front().size(), table.columns.size());
    EXPECT_EQ(table.rows.front()[6], "2.500");
    EXPECT_EQ(table.rows.front()[9], "0.40");
}

TEST_F(ArenaFile, IsRefusedWhereItIsNone) {
    EXPECT_THROW(read_arena(directory_ / "none.h5"), support::InputError);
    auto arena = tests::sample_arena();
    arena.runs[1].force.pop_back();
    arena.runs[1].force.pop_back();
    arena.runs[1].force.pop_back();
    arena.runs[1].force.pop_back(); // as if of another number of records
    write_arena(path_, arena);
    EXPECT_THROW(read_arena(path_), support::InputError);
}

TEST_F(ArenaFile, OfAnEarlierVersionHasNoSeries) {
    auto arena = tests::sample_arena();
    arena.series.clear();
    arena.methods.clear();
    write_arena(path_, arena);
    const auto read = read_arena(path_);
    EXPECT_EQ(read.runs.size(), arena.runs.size());
    EXPECT_TRUE(read.series.empty());
    EXPECT_TRUE(read.methods.empty());
}

TEST_F(ArenaFile, HasATableOfTheBestWithinEachBudget) {
    auto arena = tests::sample_arena();
    auto faster = arena.runs.front();
    faster.budget = 0.001;
    faster.outcome = ArenaOutcome::too_slow;
    arena.runs.insert(arena.runs.begin(), faster);
    const auto table = arena_overview(arena);
    ASSERT_EQ(table.rows.size(), 2U);
    EXPECT_EQ(table.rows[0],
              (std::vector<std::string>{"100", "springs", "needs 3.00 ms", "4.0", "3.00", "3.00", "3.00"}));
    EXPECT_EQ(table.rows[1][1], "blown_up");
    EXPECT_EQ(table.rows[1][3], "diverged");
    EXPECT_EQ(arena_table(arena).rows.size(), 3U);
}

TEST_F(ArenaFile, MarksIterationsThatAreALimit) {
    auto arena = tests::sample_arena();
    arena.runs.front().iterations = 11547;
    EXPECT_EQ(arena_table(arena).rows[0][5], "11547");
    arena.runs.front().stops_early = 1;
    EXPECT_EQ(arena_table(arena).rows[0][5], "up to 11547");
    EXPECT_EQ(arena_table(arena).rows[0][15], "up to 12") << "passes over its elements";
    EXPECT_EQ(arena_forces(arena).rows[0][5], "up to 11547");
    EXPECT_EQ(arena_table(arena).rows[1][5], "1");
    write_arena(path_, arena);
    const auto read = read_arena(path_);
    EXPECT_EQ(read.runs.front(), arena.runs.front());
    EXPECT_EQ(read.runs.back().stops_early, 0);
}

TEST_F(ArenaFile, NamesMethodsWhoseEffortWasFoundOnABusyMachine) {
    auto arena = tests::sample_arena();
    EXPECT_EQ(calibration_note(arena), "");
    arena.runs.front().calibration_spread = 0.2;
    const auto note = calibration_note(arena);
    EXPECT_NE(note.find("of springs were found differ by more than 5 %"), std::string::npos) << note;
}

TEST_F(ArenaFile, HasAReferenceThatFitsItsProblemAlone) {
    auto problem = tests::tool_block();
    ToolReference reference{.model = "elements",
                            .level = 2,
                            .steps_per_frame = 4,
                            .history = {},
                            .last_refinement = {.contact = 0.01, .after = 0.02, .force = 0.03, .over_time = {}},
                            .half_steps = {.contact = 0.04, .after = 0.05, .force = 0.06, .over_time = {}}};
    for (int k = 0; k <= problem.load_case.tool->num_frames; ++k) {
        reference.history.time.push_back(k * problem.load_case.tool->frame_interval);
        reference.history.force.emplace_back(k, 0.0, 0.0);
        if (core::ToolHistory::has_field(k))
            for (std::size_t i = 0; i < problem.body->mesh.points.size(); ++i)
                reference.history.displacement.emplace_back(0.0F, 0.5F, static_cast<float>(k));
    }
    write_tool_reference(path_, reference, problem, current_provenance("livermark arena --solve-reference"));
    const auto read = read_tool_reference(path_, problem, "elements");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->level, 2);
    EXPECT_EQ(read->history.force, reference.history.force);
    EXPECT_EQ(read->history.displacement, reference.history.displacement);
    EXPECT_EQ(read->last_refinement, reference.last_refinement);
    EXPECT_EQ(read->half_steps, reference.half_steps);
    EXPECT_FALSE(read_tool_reference(path_, problem, "springs"));
    problem.load_case.tool->slide.y() *= 1.001;
    EXPECT_FALSE(read_tool_reference(path_, problem, "elements"));
    EXPECT_FALSE(read_tool_reference(directory_ / "none.h5", problem, "elements"));
}

} // namespace
} // namespace livermark::results
