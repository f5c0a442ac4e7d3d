#pragma once

#include <vector>

#include "results/records/needle.hpp"

namespace livermark::tests {

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

/// One needle in two models. The numbers are made up.
inline results::NeedleFile sample_needles() {
    results::NeedleStudy study{.needle = {.name = "to tumour 1",
                                          .entry = {0.0, 0.0, 0.0},
                                          .target = {0.0, 0.0, 0.02},
                                          .diameter = 1e-3,
                                          .spread = 6e-3,
                                          .toughness = 164.0,
                                          .friction = 20.0,
                                          .puncture_force = 0.2,
                                          .step = 0.01},
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

} // namespace livermark::tests
