#pragma once

#include "results/records/cut.hpp"

namespace livermark::tests {

/// Two steps of a blade in two models and two methods that move; the second step parts nothing. The reference is
/// refined in the end, twice along facets and once of the exact cut. The numbers are made
/// up.
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

} // namespace livermark::tests
