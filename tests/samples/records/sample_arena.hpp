#pragma once

#include <limits>

#include "results/records/arena.hpp"

namespace livermark::tests {

/// Two methods within one budget, one of which has diverged, over four records and one field. The numbers are made up.
inline results::Arena sample_arena() {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
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
    lost.errors = {.contact = nan, .after = nan, .force = nan, .over_time = {nan}};
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

} // namespace livermark::tests
