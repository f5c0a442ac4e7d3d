#include "models/refined_solution.hpp"

#include <cstddef>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/observed_error.hpp"

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
        if (best->observed_error->relative_l2 <= refinement.goal)
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
    const auto num_nodes = problem.body->mesh.points.size();
    auto refined = problem;
    return solve_refined(problem, refinement, [&](int level) {
        if (level > 0)
            refined = refine(refined).problem;
        auto solution = solve(refined);
        solution.displacement.resize(num_nodes); // the nodes of the mesh come first
        for (auto &point : solution.path)
            point.displacement.resize(num_nodes);
        return solution;
    });
}

} // namespace livermark::models
