#include "models/limits_of_history.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error_norms.hpp"

namespace livermark::models {

namespace {

const std::vector<double> parts_of_load{0.0, 0.2, 0.4, 0.6, 0.8, 1.0};

/// The whole load of the history, along a path as that of other large load cases.
core::Problem at_once(core::Problem problem) {
    problem.load_case.slow_history.reset();
    problem.load_case.path = {parts_of_load.begin() + 1, parts_of_load.end()};
    return problem;
}

/// What the mesh makes wrong at one of the limits.
/// @param total  told the seconds
std::optional<core::ObservedError> error_of_mesh(const core::Problem &limit, const SolveProblem &solve,
                                                 const SolveProblem &solve_finer, core::Solution &total) {
    const auto on_mesh = solve(limit);
    const auto finer = solve_finer(limit);
    for (const auto *solution : {&on_mesh, &finer}) {
        total.setup_seconds += solution->setup_seconds;
        total.solve_seconds += solution->solve_seconds;
    }
    if (on_mesh.status != core::SolutionStatus::ok || finer.status != core::SolutionStatus::ok || !finer.observed_error)
        return std::nullopt;
    const auto comparison = core::compare(limit.body->mesh, limit.load_case, on_mesh, finer, "finer");
    auto error = *finer.observed_error;
    error.difference = comparison.relative_l2;
    error.relative_l2 += comparison.relative_l2;
    error.energy += std::abs(comparison.energy_error);
    error.reaction += comparison.reaction_error;
    if (error.stiffness && comparison.tool)
        *error.stiffness += std::abs(comparison.tool->stiffness());
    return error;
}

} // namespace

core::Problem relaxed_limit(const core::Problem &problem) {
    constexpr double no_time = 1e-12; // [s]
    auto relaxed = problem;
    auto &history = *relaxed.load_case.slow_history;
    history.relaxation.times.assign(history.relaxation.moduli.size(), no_time);
    history.times = parts_of_load; // [s]
    history.factors = parts_of_load;
    history.last_cycle.reset();
    relaxed.load_case.path = parts_of_load;
    return relaxed;
}

core::Solution solve_between_limits(const core::Problem &problem, const SolveProblem &solve,
                                    const SolveProblem &solve_finer) {
    auto history = solve(problem);
    if (history.status != core::SolutionStatus::ok)
        return history;
    const auto first = error_of_mesh(at_once(problem), solve, solve_finer, history);
    const auto last = first ? error_of_mesh(relaxed_limit(problem), solve, solve_finer, history) : std::nullopt;
    if (!last) {
        history.solver += ", error of the mesh not known: a limit has no solution on three meshes";
        return history;
    }
    auto error = first->relative_l2 > last->relative_l2 ? *first : *last;
    error.difference = std::max(first->difference, last->difference);
    error.energy = std::max(first->energy, last->energy);
    error.reaction = std::max(first->reaction, last->reaction);
    error.load_fraction = std::min(first->load_fraction, last->load_fraction);
    if (first->stiffness && last->stiffness)
        error.stiffness = std::max(*first->stiffness, *last->stiffness);
    history.observed_error = error;
    history.solver += ", on the mesh; its error from finer meshes at once and after all time";
    return history;
}

} // namespace livermark::models
