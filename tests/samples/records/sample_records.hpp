#pragma once

#include <string>
#include <vector>

#include "results/records/arena.hpp"
#include "results/records/cohort.hpp"
#include "results/records/cut.hpp"
#include "results/records/experiment.hpp"
#include "results/records/needle.hpp"
#include "results/records/springs.hpp"
#include "results/records/timings.hpp"

/// A record of each kind with everything that it can hold. All numbers here are made up.
namespace livermark::tests {

/// Two methods within one budget, one of which has diverged, over four records and one field.
inline results::Arena sample_arena() {
    results::Arena arena;
    arena.body = "blob";
    arena.load_case = "poke";
    arena.title = "A poke";
    arena.reference = "elements";
    arena.frame_interval = 0.1;
    arena.time = {0.0, 0.1, 0.2, 0.3};
    arena.reference_force = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {0, 0, 0}};
    arena.reference_errors = {.contact = 0.01, .after = 0.02, .force = 0.03, .over_time = {}};
    results::ArenaRun run;
    run.method = "springs";
    run.setting = "stable";
    run.tetrahedra = 100;
    run.budget = 0.004;
    run.steps = 12;
    run.iterations = 1;
    run.errors = {.contact = 0.04, .after = 0.2, .force = 0.05, .over_time = {0.0}};
    run.volume_error = 0.001;
    run.smallest_jacobian = 0.7;
    run.frame_seconds = 0.003;
    run.frame_seconds_95 = 0.0035;
    run.worst_frame_seconds = 0.004;
    run.setup_seconds = 0.1;
    run.release_seconds = 0.05;
    run.element_passes = 12.0;
    run.bytes_per_element = 100.0;
    run.calibration_spread = 0.01;
    run.force = arena.reference_force;
    run.pressed_force = 2.5;
    run.slid_force = 2.0;
    run.slid_ratio = 0.25;
    run.deepest = 4e-4;
    arena.runs = {run, run};
    auto &lost = arena.runs.back();
    lost.method = "blown_up";
    lost.outcome = results::ArenaOutcome::diverged;
    lost.num_inverted = 7;
    lost.errors = {.contact = results::not_known,
                   .after = results::not_known,
                   .force = results::not_known,
                   .over_time = {results::not_known}};
    arena.reference_pressed_force = 2.0;
    arena.methods = {{"springs", "Somebody 2001", "a loop", "the motion of its springs", "Nobody would do that."},
                     {"blown_up", "Nobody 2002", "two loops", "nothing", "It blows up."}};
    for (const int iterations : {1, 2, 4}) {
        arena.series.push_back(run);
        auto &last = arena.series.back();
        last.setting = "one step";
        last.budget = last.calibration_spread = 0.0;
        last.steps = 1;
        last.iterations = iterations;
        last.errors.contact = 0.4 / iterations;
        last.pressed_force = iterations; // half of that of the reference, and twice that
    }
    return arena;
}

/// A calibration that fits a body.
inline results::Calibration sample_calibration(const core::Body &body) {
    results::Calibration calibration;
    calibration.body = body.name;
    calibration.spring_law = "patch";
    calibration.volume_term = "nodal_volume";
    calibration.reference = "fem_p2p1";
    calibration.constrained = "x_min";
    calibration.seed = 7;
    calibration.iterations = 40;
    calibration.penalty = 0.25;
    calibration.springs.materials = body.materials;
    calibration.springs.edges = core::edge_table(body.mesh.tetrahedra).edges;
    for (const auto &[i, j] : calibration.springs.edges) {
        const double length = (body.mesh.points[j] - body.mesh.points[i]).norm();
        calibration.springs.rest_length.push_back(length);
        calibration.springs.stiffness.push_back(1.0 / length);
        calibration.start_stiffness.push_back(100.0 * length);
    }
    calibration.held_out = {0, 0, 1};
    calibration.error_before = {0.5, 0.25, 0.125};
    calibration.error_after = {0.1, 0.05, 0.025};
    return calibration;
}

/// Three bodies, one of which has failed, and two models, one of which has not come to an end on one body. The numbers
/// are made up.
inline results::Cohort sample_cohort() {
    using enum core::Regime;
    using enum core::SolutionStatus;
    const results::CohortLesion lesion{{0.01, 0.02, 0.03}, {0.009, 0.008, 0.007}};
    results::Cohort cohort;
    cohort.tetrahedra = 2000;
    cohort.bodies = {{1, "liver_variant_1", 1.1e-3, 1.6, 0.1, 0.9, false, {lesion, lesion}},
                     {2, "liver_variant_2", 1.5e-3, 1.8, 0.2, 1.1, true, {}},
                     {3, "liver_variant_3", 1.9e-3, 2.0, 0.15, 1.0, false, {lesion, lesion}}};
    const std::string linear = "fem_p2p1_refined", hyperelastic = "fem_p2p1_neo_hookean";
    cohort.errors = {
        {"liver_variant_1", small, 0.45, "palpation", "springs", ok, 0.04, 0.05, -0.15, linear, 1.2, 0.004, 0.007},
        {"liver_variant_1", small, 0.45, "traction", "springs", ok, 0.06, 0.07, 0.05, linear, 3.5, 0.002, 0.003},
        {"liver_variant_2", small, 0.45, "palpation", "springs", ok, 0.03, 0.02, 0.08, linear, 1.1, 0.005, 0.009},
        {"liver_variant_2", small, 0.45, "traction", "springs", ok, 0.05, results::not_known, results::not_known,
         linear},
        {"liver_variant_1", large, 0.45, "large_traction", "blown_up", diverged, results::not_known, results::not_known,
         results::not_known, hyperelastic}};
    cohort.failures = {"liver_variant_3: gmsh fails", "liver_variant_2: pneumoperitoneum: does not move"};
    return cohort;
}

/// Two steps of a blade in two models and two methods that move; the second step parts nothing. The reference is
/// refined in the end, twice along facets and once of the exact cut.
inline results::CutFile sample_cut() {
    results::CutFile cut{.provenance = {}, .body = "block", .load_case = "traction", .title = "Pulled"};
    cut.blade = {core::Vector3(0.0, 0.0, 0.01), core::Vector3(0.0, 0.02, 0.01), core::Vector3(0.02, 0.02, 0.01),
                 core::Vector3(0.02, 0.0, 0.01)};
    cut.toughness = 100.0;
    cut.depth = {0.0, 0.01, 0.02};
    cut.area = {0.0, 2e-4, 2e-4};
    cut.cut_seconds = {0.0, 0.25, 0.125};
    cut.nodes = {100, 110, 110};
    cut.runs = {{.model = "judge",
                 .stored = {0.010, 0.015, 0.015},
                 .work = {0.020, 0.030, 0.030},
                 .opening = {0.0, 0.002, 0.002},
                 .tool_stiffness = {40.0, 30.0, 30.0},
                 .setup_seconds = {1.5, 1.0, 0.0},
                 .solve_seconds = {2.0, 3.0, 0.0}},
                {.model = "springs",
                 .stored = {0.012, 0.018, 0.018},
                 .work = {0.024, 0.036, 0.036},
                 .opening = {0.0, 0.003, 0.003},
                 .tool_stiffness = {50.0, 36.0, 36.0},
                 .setup_seconds = {0.1, 0.05, 0.0},
                 .solve_seconds = {0.2, 0.3, 0.0},
                 .critical_time_step = {0.00282, 0.002, 0.00047}}};
    cut.regime = core::Regime::large;
    cut.levels = {{"facets", 200, 2e-4, 0.018, 0.002, 30.0, 3.0},
                  {"facets", 300, 2e-4, 0.018, 0.0024, 29.0, 6.0},
                  {"facets", 500, 2e-4, 0.018, 0.0026, 28.5, 12.0},
                  {"exact", 250, 2.5e-4, 0.016, 0.003, 27.0, 4.0},
                  {"exact", 350, 2.5e-4, 0.016, 0.0031, 26.5, 8.0}};
    cut.frame_interval = 0.02;
    cut.frames_per_step = 5;
    cut.motions = {{.method = "springs",
                    .setting = "stable",
                    .budget = 0.004,
                    .steps = 12,
                    .iterations = 1,
                    .setup_seconds = 0.5,
                    .frame_seconds = 0.002,
                    .worst_frame_seconds = 0.052,
                    .opening = {0.0, 0.001, 0.003},
                    .tool_stiffness = {50.0, 45.0, 36.0},
                    .ready_seconds = {0.0, 0.05, 0.0}},
                   {.method = "elements",
                    .setting = "one step",
                    .budget = 0.001,
                    .steps = 1,
                    .iterations = 3,
                    .setup_seconds = 0.75,
                    .frame_seconds = 0.0015,
                    .worst_frame_seconds = 0.004,
                    .opening = {0.0, 0.0005, 0.0018},
                    .tool_stiffness = {60.0, 55.0, 33.0},
                    .ready_seconds = {0.0, 0.0025, 0.0}}};
    return cut;
}

/// Markers that go up and down.
inline std::vector<core::Vector3> sample_swings(double reach) {
    std::vector<core::Vector3> displacement; // six records of five markers
    for (int j = 0; j < 6; ++j)
        displacement.insert(displacement.end(), 5, core::Vector3(0.0, 0.0, j % 2 == 0 ? reach : -reach));
    return displacement;
}

/// A state of it that rings down, beside two models, one of which is lost.
inline results::RingDownResult sample_ring_down() {
    results::RingDownResult ring_down{.state = "much",
                                      .interval = 0.01,
                                      .displacement = sample_swings(0.002),
                                      .frequency = 4.0,
                                      .frequency_uncertainty = 0.1,
                                      .damping_ratio = 0.05,
                                      .damping_uncertainty = 0.004,
                                      .swings = {4e-3, 3e-3, 2e-3, 1e-3},
                                      .swing_noise = 2e-4,
                                      .noise = 3e-4,
                                      .no_motion = 2e-3,
                                      .rigid_motion = 1e-4,
                                      .runs = {}};
    results::RingDownRun run{.model = "springs", .tetrahedra = 1};
    run.integrator = "runge_kutta_4";
    run.damping = {1.0, 2e-3};
    run.time_step = 1e-4;
    run.frequency = 4.2;
    run.damping_ratio = 0.06;
    run.swings = {4e-3, 3e-3, 2e-3, 1.5e-3};
    run.swing_error = 2.5e-4;
    run.error = 4e-4;
    run.start_error = 1e-5;
    run.seconds = 2.0;
    run.displacement = sample_swings(0.0021);
    ring_down.runs = {run, run};
    ring_down.runs.front().model = "lost";
    ring_down.runs.front().status = core::SolutionStatus::diverged;
    ring_down.runs.front().message = "it flew away";
    ring_down.runs.front().error = std::numeric_limits<double>::quiet_NaN();
    return ring_down;
}

/// Five markers in two states beside three models, one of which has no solution, on a body of one tetrahedron.
inline results::ExperimentResult sample_experiment() {
    using core::Vector3;
    results::ExperimentResult result;
    result.name = "jelly";
    result.title = "A jelly under a spoon";
    result.source = "our kitchen";
    result.assumptions = {"the plate does not move", "the spoon has no weight", "it is a jelly"};
    result.reference = "elements";
    result.markers = {"a", "b", "c", "d", "e"};
    result.drives = {"", "", "", "top", ""};
    for (int k = 0; k < 5; ++k)
        result.positions.emplace_back(0.01 * k, 0.02, 0.0);
    results::ExperimentState state{.name = "little", .noise = 1e-4, .no_motion = 2e-3, .rigid_motion = 1e-3};
    state.displacement.assign(5, Vector3(0.0, 0.0, -0.002));
    state.deformed.assign(4, Vector3(0.0, 0.0, -0.002));
    result.states = {state, state};
    result.states.back().name = "much";
    result.states.back().displacement.front() = Vector3::Constant(results::not_known);
    result.states.back().straight_line = 5e-4;
    result.states.back().reference_uncertainty = 2e-5;
    for (const auto &[model, tetrahedra] : {std::pair{"springs", 1}, {"elements", 1}, {"elements", 8}})
        for (int s = 0; s < 2; ++s)
            result.runs.push_back({.model = model,
                                   .state = s,
                                   .tetrahedra = tetrahedra,
                                   .error = 1e-4 * (s + 1),
                                   .worst_error = 2e-4,
                                   .seconds = 0.5,
                                   .displacement = std::vector<Vector3>(5, Vector3(0.0, 0.0, -0.0021))});
    result.runs[1].status = core::SolutionStatus::not_converged;
    result.runs[1].message = "it wobbles";
    result.points = {Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};
    result.boundary = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}};
    result.forces = {{.state = "much",
                      .place = "top",
                      .way = {0.001, 0.003, 0.006},
                      .force = {1.0, 3.2, 8.0},
                      .deviation = {0.02, 0.1, 0.3},
                      .young_modulus = 5e3,
                      .uniform = {2.0, 6.2, 15.0},
                      .runs = {{.model = "springs", .tetrahedra = 1, .force = {0.5, 1.6, 4.4}, .seconds = 0.25},
                               {.model = "lost",
                                .tetrahedra = 1,
                                .status = core::SolutionStatus::diverged,
                                .message = "it tore",
                                .force = {0.5, results::not_known, results::not_known},
                                .seconds = 0.5},
                               {.model = "elements", .tetrahedra = 1, .force = {2.0, 6.3, 15.0}, .seconds = 1.0},
                               {.model = "elements", .tetrahedra = 8, .force = {2.0, 6.4, 16.0}, .seconds = 8.0}}}};
    result.fits = {{.model = "springs",
                    .error = 2e-4,
                    .young_modulus = 4e3,
                    .error_of_modulus = 1e-4,
                    .poisson_ratio = 0.49,
                    .error_of_ratio = 1.5e-4}};
    result.ring_downs = {sample_ring_down()};
    result.damping_from = "much";
    return result;
}

/// Two steps in and two out.
inline core::Insertion sample_insertion(double force) {
    core::Insertion found;
    for (int j = 0; j < 5; ++j) {
        found.depth.push_back(0.01 * (j < 3 ? j : 4 - j));
        found.force.push_back(j < 3 ? force * j : -0.5 * force);
        found.tip.push_back(0.008 * j);
        found.target.emplace_back(0.0, 0.003, 0.004);
        found.entry.push_back(0.001);
        found.work.push_back(0.1 * j);
        found.stored.push_back(0.02 * j);
        found.friction.push_back(0.03 * j);
        found.tearing.push_back(0.05 * j);
        found.holding.push_back(0.001 * j);
    }
    found.at_plan = 2;
    return found;
}

/// Two methods under a needle that is led in two frames, and one that is left out.
inline results::NeedleArena sample_needle_arena() {
    results::NeedleArena arena{.speed = 0.6,
                               .rest = 0.0,
                               .mass_damping = 10.0,
                               .frame_interval = 1.0 / 60.0,
                               .at_plan = 2,
                               .depth = {0.0, 0.01, 0.02, 0.01, 0.0},
                               .reference_force = {0.0, 1.0, 2.0, -0.5, -0.4},
                               .reference_target = std::vector<core::Vector3>(5, core::Vector3(0.0, 0.003, 0.004)),
                               .reference_forces = {2.0, 100.0, 0.5},
                               .reference_changes = {0.01, 1.0, 0.002},
                               .runs = {},
                               .left_out = {{"heavy", "its masses are scaled"}}};
    for (const char *name : {"springs", "iterations"}) {
        auto &run = arena.runs.emplace_back();
        run.method = name;
        run.setting = "stable";
        run.tetrahedra = 100;
        run.budget = 0.01;
        run.steps = 12;
        run.iterations = 1;
        run.force = {0.0, 1.1, 2.2, -0.6, -0.4};
        run.tip = {0.0, 0.009, 0.018, 0.009, 0.0};
        run.target = arena.reference_target;
        run.target_error = arena.runs.size() == 1 ? 2e-3 : 1e-3;
        run.path_error = 0.1;
        run.forces = {2.2, 110.0, 0.6};
        run.frame_seconds = 0.002;
        run.frame_seconds_95 = 0.003;
        run.worst_frame_seconds = 0.004;
        run.cost_ratio = 1.05;
        run.setup_seconds = 0.1;
        run.calibration_spread = 0.01;
    }
    return arena;
}

/// One needle in two models.
inline results::NeedleFile sample_needles() {
    results::NeedleStudy study{.needle = {.name = "to tumour 1",
                                          .entry = {0.0, 0.0, 0.0},
                                          .target = {0.0, 0.0, 0.02},
                                          .diameter = 1e-3,
                                          .spread = 6e-3,
                                          .toughness = 164.0,
                                          .friction = 20.0,
                                          .puncture_force = 0.2,
                                          .step = 0.01,
                                          .side_stiffness = 1e5},
                               .runs = {{"judge", sample_insertion(1.0), 3.0}, {"springs", sample_insertion(1.1), 0.5}},
                               .reference_miss_change = 1e-5,
                               .reference_force_change = 0.004};
    study.runs[1].insertion.puncture_depth = 0.01;
    study.runs[1].insertion.stopped_at = 0.005;
    study.runs[1].solve_seconds = 7.0;
    study.arena = sample_needle_arena();
    return {.provenance = {},
            .body = "block",
            .load_case = "biopsy",
            .title = "Biopsy",
            .regime = core::Regime::large,
            .needles = {study}};
}

/// Three repetitions of three benchmarks with every counter that there is.
inline results::Timings sample_timings() {
    const std::vector<double> seconds{0.3, 0.1, 0.2};
    return {.provenance = {},
            .timings = {{.name = "step/newmark/fem_p1/box",
                         .seconds = seconds,
                         .iterations = 7,
                         .counters = {{"springs", 20.0},
                                      {"time_per_spring", 0.01},
                                      {"of_limit", 0.5},
                                      {"bytes_per_spring", 24.0},
                                      {"held_steps", 13.0},
                                      {"steps_per_second", 5.0},
                                      {"time_step", 0.004},
                                      {"real_time_factor", 0.02}}},
                        {.name = "step/newmark/all",
                         .seconds = seconds,
                         .is_wall_clock = true,
                         .iterations = 1,
                         .counters = {{"nodes", 8.0},
                                      {"unknowns", 24.0},
                                      {"bytes", 1024.0},
                                      {"bytes_per_second", 1e9},
                                      {"flop_per_second", 2e9}}},
                        {.name = "bullet/forces/box",
                         .seconds = seconds,
                         .is_wall_clock = true,
                         .iterations = 3,
                         .counters = {{"livermark", 0.02},
                                      {"bullet", 0.03},
                                      {"bullet_over_livermark", 1.5},
                                      {"inner_iterations", 1.0},
                                      {"difference", 1e-4},
                                      {"difference_converged", 1e-5}}}}};
}

/// Two integrators, one of which was observed.
inline results::Stability sample_stability() {
    results::Stability stability;
    stability.limits = {{"symplectic_euler", {1e-3, 1.1e-3}, {2e-3}}, {"explicit_euler", {}, {3e-3, 3.1e-3}}};
    return stability;
}

} // namespace livermark::tests
