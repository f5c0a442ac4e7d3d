#include "studies/models/refined_solution.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error_norms.hpp"

namespace livermark::models {

namespace {

constexpr std::size_t enough_levels = 3; ///< to observe an order

/// The finest of the levels that have a solution, and its error where three levels have come to.
/// @param levels     the first num_solved have a solution, the others a part of the path
/// @param why_ended  the message of the level without a solution, or empty
core::Solution finest_solved(const core::Problem &problem, std::vector<core::Solution> levels, std::size_t num_solved,
                             const std::string &why_ended) {
    auto best = levels[num_solved - 1];
    best.solver += fmt::format(", finest of {} meshes that have a solution", num_solved);
    if (levels.size() >= enough_levels) {
        best.observed_error =
            core::observed_error_on_path(problem.body->mesh, problem.load_case, levels, num_solved - 1);
        best.solver +=
            fmt::format(", error observed at {:.0f} % of the load", 100.0 * best.observed_error->load_fraction);
    }
    if (!why_ended.empty())
        best.solver += "; on the next mesh " + why_ended;
    return best;
}

/// Bar of displacement, energy, reactions or stiffness at the tool.
double largest_bar(const core::ObservedError &error) {
    return std::max({error.relative_l2, error.energy, error.reaction, error.stiffness.value_or(0.0)});
}

const std::vector<double> parts_of_load{0.0, 0.2, 0.4, 0.6, 0.8, 1.0};

/// The whole load of the history, along a path as that of other large load cases.
core::Problem at_once(core::Problem problem) {
    problem.load_case.slow_history.reset();
    problem.load_case.path = {parts_of_load.begin() + 1, parts_of_load.end()};
    return problem;
}

/// Error of the mesh at one of the limits.
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

core::Solution solve_refined(const core::Problem &problem, const Refinement &refinement,
                             const std::function<core::Solution(int level)> &solve) {
    std::vector<core::Solution> levels;
    std::size_t num_solved = 0;
    std::optional<core::Solution> best;
    std::string why_ended;
    double setup_seconds = 0.0, solve_seconds = 0.0;
    for (int level = 0; level <= refinement.finest_level; ++level) {
        auto solution = solve(level);
        solution.displacement.resize(problem.body->mesh.points.size()); // the nodes of the mesh come first
        for (auto &point : solution.path)
            point.displacement.resize(problem.body->mesh.points.size());
        setup_seconds += solution.setup_seconds;
        solve_seconds += solution.solve_seconds;
        const bool is_solved = solution.status == core::SolutionStatus::ok && num_solved == levels.size();
        if (!is_solved && num_solved > 0 && why_ended.empty())
            why_ended = solution.message;
        if (is_solved || levels.empty() || (!best && !solution.path.empty()))
            levels.push_back(std::move(solution));
        else
            break;
        if (is_solved)
            ++num_solved;
        if (num_solved == 0 || (num_solved < levels.size() && levels.size() >= enough_levels))
            break;
        if (num_solved < enough_levels)
            continue;
        best = core::extrapolated(problem.body->mesh, problem.load_case, levels);
        best->solver += fmt::format(", finest of {} meshes, extrapolated", levels.size());
        if (largest_bar(*best->observed_error) <= refinement.goal)
            break;
    }
    if (!best)
        best = num_solved == 0 ? std::move(levels.front())
                               : finest_solved(problem, std::move(levels), num_solved, why_ended);
    best->setup_seconds = setup_seconds;
    best->solve_seconds = solve_seconds;
    return std::move(*best);
}

core::Solution solve_locally_refined(const core::Problem &problem, const Refinement &refinement,
                                     const RefineProblem &refine,
                                     const std::function<core::Solution(const core::Problem &)> &solve) {
    auto refined = problem;
    return solve_refined(problem, refinement, [&](int level) {
        if (level > 0)
            refined = refine(refined).problem;
        return solve(refined);
    });
}

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
