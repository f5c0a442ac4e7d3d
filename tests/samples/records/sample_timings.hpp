#pragma once

#include "results/records/timings.hpp"

namespace livermark::tests {

/// Three repetitions of three benchmarks with every counter that there is. The numbers are made up.
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

} // namespace livermark::tests
