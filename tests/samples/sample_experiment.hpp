#pragma once

#include <limits>

#include "results/records/experiment.hpp"

namespace livermark::tests {

/// Five markers in two states beside three models, one of which has no solution, on a body of one tetrahedron. The
/// numbers are made up.
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
    return result;
}

} // namespace livermark::tests
