// Tables of records and the sentences below them: what was reviewed is in tests/golden/, what has to hold is here.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/golden.hpp"
#include "tests/samples/records/sample_records.hpp"

namespace livermark::results {
namespace {

using tests::expect_golden;

constexpr double any_step = std::numeric_limits<double>::infinity();

TEST(ArenaTables, HaveAllRunsAndTheBestWithinEachBudget) {
    auto arena = tests::sample_arena();
    auto faster = arena.runs.front();
    faster.budget = 0.001;
    faster.outcome = ArenaOutcome::too_slow;
    arena.runs.insert(arena.runs.begin(), faster);
    expect_golden("arena", to_text(arena_table(arena)) + "\n" + to_text(arena_overview(arena)));
}

TEST(ArenaTables, SayHowStiffAMethodIsWithEachNumberOfIterations) {
    auto arena = tests::sample_arena();
    expect_golden("arena_series", to_text(arena_series(arena)));
    arena.reference_pressed_force = not_known;
    EXPECT_EQ(arena_series(arena).rows[0][8], "-");
}

TEST(ArenaTables, MarkIterationsThatAreALimit) {
    auto arena = tests::sample_arena();
    arena.runs.front().iterations = 11547;
    EXPECT_EQ(arena_table(arena).rows[0][5], "11547");
    arena.runs.front().stops_early = 1;
    EXPECT_EQ(arena_table(arena).rows[0][5], "up to 11547");
    EXPECT_EQ(arena_table(arena).rows[0][15], "up to 12") << "passes over its elements";
    EXPECT_EQ(arena_table(arena).rows[1][5], "1");
}

TEST(ArenaTables, SayWhatTheToolIs) {
    auto arena = tests::sample_arena();
    EXPECT_EQ(tool_of(arena), "the tool has hold of its place");
    arena.tool = touching_tool;
    arena.friction = 0.3;
    arena.ball_radius = 0.012;
    expect_golden("arena_forces", to_text(arena_forces(arena)) + tool_of(arena) + "\n");
    arena.face = core::ToolFace::square;
    arena.plate_size = 0.02;
    EXPECT_NE(tool_of(arena).find("a square plate of 20 mm"), std::string::npos) << tool_of(arena);
}

TEST(ArenaTables, NameMethodsWhoseEffortWasFoundOnABusyMachine) {
    auto arena = tests::sample_arena();
    EXPECT_EQ(calibration_note(arena), "");
    arena.runs.front().calibration_spread = 0.2;
    const auto note = calibration_note(arena);
    EXPECT_NE(note.find("of springs were found differ by more than 5 %"), std::string::npos) << note;
}

TEST(CutTables, CompareWithTheFinestMeshOfTheReference) {
    auto file = tests::sample_cut();
    expect_golden("cut", to_text(cut_models_table(file)) + cut_judge_note(file) + "\n" +
                             to_text(cut_levels_table(file)) + cut_levels_note(file) + "\n" +
                             to_text(cut_motions_table(file)));
    const auto opening = file.in_the_end("facets", &CutLevel::opening);
    ASSERT_TRUE(opening);
    EXPECT_EQ(opening->value, 0.0026);
    EXPECT_NEAR(opening->error, 2e-4, 1e-12);                   // steps of 0.4 and 0.2 mm: as much again is to come
    EXPECT_FALSE(file.in_the_end("exact", &CutLevel::opening)); // two meshes say no order
    file.levels.erase(file.levels.begin());                     // nor are they enough to judge
    EXPECT_FALSE(file.judge_in_the_end().is_refined);
}

TEST(CutTables, SayWhatACutSetsFree) {
    auto file = tests::sample_cut();
    file.levels.clear();
    expect_golden("cut_on_mesh", to_text(cut_table(file)) + cut_note(file) + "\n" + to_text(cut_models_table(file)) +
                                     cut_judge_note(file) + "\n" + to_text(cut_motions_table(file)));
    EXPECT_NEAR(file.runs[0].released(1), 0.005, 1e-15);
    EXPECT_NEAR(file.release_rate(file.runs[0], 1), 25.0, 1e-10);
    EXPECT_TRUE(std::isnan(file.release_rate(file.runs[0], 2)));
    EXPECT_NEAR(file.tearing(2), 0.02, 1e-15);
    // Of the steps that have parted something, so not of the second.
    EXPECT_EQ(file.ready_seconds(file.runs[0]), std::vector<double>{1.25});
    EXPECT_EQ(file.equilibrium_seconds(file.runs[0]), std::vector<double>{2.0});
    file.toughness = 20.0;
    EXPECT_NE(cut_note(file).find("1 of 1 steps"), std::string::npos) << cut_note(file);
}

TEST(CutTables, RankMotionsOfABudgetByTheLargerError) {
    auto file = tests::sample_cut();
    const auto sample = file.motions.front();
    const auto add = [&](const char *method, double opening, double stiffness, double frame_seconds) {
        auto motion = sample;
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
    add("lost", not_known, not_known, 0.001);
    add("slow", 0.002, 30.0, 0.02);              // exact, but too late
    add("opens well", 0.002, 36.0, 0.001);       // 20 % off at the tool
    add("opens less well", 0.0022, 30.0, 0.001); // 10 % off in the opening
    add("slow", 0.0025, 30.0, 0.001);            // the same method, in time
    std::vector<std::vector<std::string>> found; // method, in time, larger, whose
    for (const auto &row : cut_motions_table(file).rows)
        found.push_back({row[0], row[2], row[8], row[9]});
    EXPECT_EQ(found, (std::vector<std::vector<std::string>>{{"opens less well", "yes", "10.0", "opening"},
                                                            {"opens well", "yes", "20.0", "tool"},
                                                            {"slow", "yes", "25.0", "opening"},
                                                            {"lost", "yes", "-", "-"}}));
    // Without a tool the opening alone counts.
    for (auto &stiffness : {&file.runs.front().tool_stiffness, &file.motions[2].tool_stiffness})
        stiffness->back() = not_known;
    std::erase_if(file.motions, [](const CutMotion &motion) { return motion.method != "opens well"; });
    EXPECT_EQ(cut_motions_table(file).rows.front()[8], "0.0");
    EXPECT_EQ(cut_motions_table(file).rows.front()[9], "opening");
}

TEST(CutTables, SayTheStepsOfSpringsBeforeAndAfter) {
    auto file = tests::sample_cut();
    const std::vector<std::string> row{"springs", "2.820", "2.000", "0.470"};
    ASSERT_EQ(cut_steps_table(file).rows.size(), 1U); // of the model that has springs
    EXPECT_EQ(cut_steps_table(file).rows.front(), row);
    file.runs[1].critical_time_step.pop_back();
    EXPECT_EQ(cut_steps_table(file).rows.front().back(), "-"); // no exact cut
    file.runs.pop_back();
    EXPECT_TRUE(cut_steps_table(file).rows.empty());
}

TEST(NeedleTables, HaveModelsAndMethodsAndTheBetterTargetFirst) {
    const auto file = tests::sample_needles();
    const auto &study = file.needles.front();
    expect_golden("needle", to_text(needle_table(file)) + needle_note(file) + "\n" +
                                to_text(needle_arena_table(*study.arena)) + needle_arena_note(study));
}

TEST(NeedleTables, SetModelsBesideWhatWasMeasured) {
    const MeasuredNeedle measured{.source = "a hand",
                                  .unknown = {},
                                  .needle = {},
                                  .from = {0.0, 0.005},
                                  .to = {0.005, 0.01},
                                  .mean = {0.5, 1.0},
                                  .lowest = {0.25, 0.75},
                                  .highest = {1.0, 2.0},
                                  .puncture_depth = 0.004,
                                  .work = 0.0075,
                                  .runs = {{.model = "springs",
                                            .stiffness = 1.25,
                                            .friction = 30.0,
                                            .insertion = {},
                                            .force = {0.37, not_known},
                                            .error = 0.13,
                                            .error_before = 0.25,
                                            .work = 0.0085}}};
    expect_golden("needle_measured",
                  to_text(measured_needle_table(measured)) + "\n" + to_text(fitted_needle_table(measured)));
}

TEST(NeedleTables, HaveTheWayOutAndTheHoldOfRecordsThatHaveThem) {
    MeasuredNeedle measured{.source = "a hand",
                            .unknown = {},
                            .needle = {},
                            .from = {0.0, 0.00025},
                            .to = {0.00025, 0.0005},
                            .mean = {0.5, 1.0},
                            .lowest = {0.25, 0.75},
                            .highest = {1.0, 2.0},
                            .puncture_depth = 0.0004,
                            .work = 0.0075,
                            .runs = {{.model = "springs", .insertion = {}, .force = {0.37, 0.4}}}};
    measured.name = "a record";
    measured.needle.puncture_force = 0.9;
    measured.runs.front().friction = 30.0;
    measured.touched_at = 0.0002;
    measured.lowest_behind = 0.05;
    measured.slope = 210.0;
    EXPECT_EQ(measured_needle_table(measured).rows[1].front(), "0.25 to 0.50");
    EXPECT_EQ(fitted_needle_table(measured).columns.size(), 6U);
    auto held = measured;
    held.pull = 0.15;
    held.runs.front().pull = 0.4;
    held.held_for = 8.0;
    held.held_from = 0.35;
    held.held_to = 0.25;
    EXPECT_EQ(fitted_needle_table(held).rows.front().back(), "0.40");
    EXPECT_EQ(fitted_needle_table(held).rows.back().back(), "0.15");
    auto steeper = measured;
    steeper.runs.front().has_friction = false;
    EXPECT_EQ(fitted_needle_table(steeper).rows.front()[2], "none below 30");
    const std::vector<MeasuredNeedle> both{measured, held};
    const auto table = needle_records_table(both);
    const std::vector<std::string> first{"a record", "0.2", "0.4", "0.90", "0.05", "210.0", "30.0", "-", "-", "-", "-"},
        second{"a record", "0.2", "0.4", "0.90", "0.05", "210.0", "30.0", "8.0", "0.35", "0.25", "0.15"};
    EXPECT_EQ(table.rows, (std::vector{first, second}));
    EXPECT_EQ(table.columns[6].title, "friction, springs [N/m]");
}

TEST(NeedleTables, SayWhereTheSmallRegimeIsLeft) {
    auto file = tests::sample_needles();
    EXPECT_EQ(needle_note(file).find("small regime"), std::string::npos);
    auto &run = file.needles.front().runs.back();
    run.insertion.moved = {0.0, 0.004, 0.009, 0.02, 0.02};
    run.note_limit(0.009);
    EXPECT_TRUE(std::isnan(run.left_regime_at)) << "on the way out it is too late";
    run.note_limit(0.003);
    EXPECT_EQ(run.left_regime_at, 0.01);
    EXPECT_NE(needle_note(file).find("to tumour 1: small regime left at 10.0 mm (springs)"), std::string::npos);
    EXPECT_NE(needle_note(file).find("use --regime large"), std::string::npos);
}

/// The force that the surface bears until it gives way is between two records.
TEST(NeedleTables, HaveALargestForceNotBelowThatOfThePuncture) {
    const auto study = tests::sample_needles().needles.front();
    auto needle = study.needle;
    needle.puncture_force = 3.5;
    EXPECT_EQ(study.runs[0].largest_force(needle), 2.0) << "its surface holds";
    EXPECT_EQ(study.runs[1].largest_force(needle), 3.5);
    needle.puncture_force = 0.2;
    EXPECT_EQ(study.runs[1].largest_force(needle), 2.2);
}

TEST(NeedleTables, SayWhoseWorkIsOutOfBalance) {
    auto file = tests::sample_needles();
    EXPECT_EQ(needle_note(file).find("miss"), std::string::npos);
    file.needles.front().runs.front().insertion.stored[2] += 0.02; // of 0.2 J
    EXPECT_NE(needle_note(file).find("energies of judge miss"), std::string::npos) << needle_note(file);
}

TEST(ExperimentTables, HaveModelsWithoutASolutionLast) {
    auto result = tests::sample_experiment();
    compare_with_reference(result);
    std::string notes;
    for (const auto &note : notes_on_nulls(result))
        notes += note + "\n";
    expect_golden("experiment", to_text(experiment_table(result)) + "\n" + to_text(marker_table(result)) + "\n" +
                                    to_text(force_table(result)) + to_text(fit_table(result)) + notes + "\n" +
                                    to_text(ring_down_table(result)) + ring_down_note(result) + "\n");
    result.ring_downs.clear();
    EXPECT_TRUE(ring_down_table(result).rows.empty());
    EXPECT_EQ(ring_down_note(result), "");
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

/// Errors of two models at the same beads: of a difference that all beads share the interval is narrow, and of one that
/// comes and goes it has zero in it, however large both errors are.
TEST(MarkerError, IsComparedBeadByBead) {
    auto result = tests::sample_experiment();
    constexpr int num_beads = 200;
    result.markers.assign(num_beads, "bead");
    result.drives.assign(num_beads, "");
    result.states.resize(1);
    result.states[0].displacement.assign(num_beads, core::Vector3::Zero());
    result.runs.clear();
    const auto add = [&](const char *model, auto error_at) {
        ExperimentRun run{.model = model};
        for (int k = 0; k < num_beads; ++k)
            run.displacement.emplace_back(1e-3 * error_at(k), 0.0, 0.0);
        run.error = marker_error(result, run.displacement, result.states[0].displacement).root_mean_square;
        result.runs.push_back(run);
    };
    const auto noise = [](int k) { return 1.0 + 0.5 * std::sin(1.7 * k); };
    add("worse", [&](int k) { return noise(k) + 0.05; });
    add("other", [&](int k) { return noise(k) + 0.3 * std::sin(5.1 * k); });
    add("elements", noise);
    compare_with_reference(result);
    const auto &worse = result.runs[0].beyond_reference, &other = result.runs[1].beyond_reference;
    EXPECT_NEAR(worse[0], 0.05e-3, 0.01e-3);
    EXPECT_GT(worse[1], 0.04e-3);
    EXPECT_LT(worse[2], 0.06e-3);
    EXPECT_LT(other[1], 0.0);
    EXPECT_GT(other[2], 0.0);
    EXPECT_EQ(result.runs[2].beyond_reference, std::vector<double>(3, 0.0)) << "the reference itself";
}

TEST(StabilityTable, SaysWhereNoStepAndEveryStepIsStable) {
    auto stability = tests::sample_stability();
    stability.body = "box";
    stability.spring_law = "lloyd";
    stability.limits.push_back({"implicit_euler", {any_step}, {any_step}});
    expect_golden("stability", to_text(stability_table(stability)) + step_advice(stability, 0.8) + "\n");
}

TEST(StepAdvice, IsAPartOfTheLongestStableStep) {
    Stability stability;
    stability.body = "box";
    stability.spring_law = "lloyd";
    const auto advice = [&](std::vector<IntegratorLimits> limits, double part = 0.8) {
        stability.limits = std::move(limits);
        return step_advice(stability, part);
    };
    EXPECT_EQ(advice({{"runge_kutta_4", {2e-3}, {2e-3}}, {"symplectic_euler", {1e-3}, {5e-4}}}),
              "box, lloyd: take 0.8 ms, 0.8 of the longest stable step of symplectic_euler; with this damping 0.4 ms");
    EXPECT_EQ(
        advice({{"explicit_euler", {0.0}, {1e-4}}, {"implicit_euler", {any_step}, {any_step}}, {"heun", {1e-3}, {0.0}}},
               0.5),
        "box, lloyd: take 0.5 ms, 0.5 of the longest stable step of heun; with this damping no step");
    EXPECT_EQ(advice({{"implicit_euler", {any_step}, {any_step}}}), "box, lloyd: take any step, none is unstable");
    EXPECT_NE(advice({{"explicit_euler", {0.0}, {1e-4}}}).find("take another integrator"), std::string::npos);
    stability.model = "nodal_springs";
    EXPECT_TRUE(advice({{"symplectic_euler", {1e-3}, {5e-4}}}).starts_with("box, nodal_springs: take 0.8 ms"));
}

} // namespace
} // namespace livermark::results
