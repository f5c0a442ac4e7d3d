#pragma once

#include <limits>

#include "results/records/experiment.hpp"

namespace livermark::tests {

/// Markers that go up and down. All numbers here are made up.
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
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
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
    result.states.back().displacement.front() = Vector3::Constant(nan);
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
    result.ring_downs = {sample_ring_down()};
    result.damping_from = "much";
    return result;
}

} // namespace livermark::tests
