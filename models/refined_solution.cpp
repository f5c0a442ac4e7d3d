#include "models/refined_solution.hpp"

#include <fmt/format.h>
#include <utility>

#include "core/observed_error.hpp"

namespace livermark::models {

core::Solution solve_refined(const core::TetraMesh &mesh, const Refinement &refinement,
                             const std::function<core::Solution(int level)> &solve) {
    std::vector<core::Solution> levels;
    std::optional<core::Solution> best;
    double setup_seconds = 0.0, solve_seconds = 0.0;
    for (int level = 0; level <= refinement.finest_level; ++level) {
        auto solution = solve(level);
        setup_seconds += solution.setup_seconds;
        solve_seconds += solution.solve_seconds;
        const bool is_solved = solution.status == core::SolutionStatus::ok;
        if (is_solved || levels.empty())
            levels.push_back(std::move(solution));
        if (!is_solved)
            break;
        if (levels.size() < 3)
            continue;
        best = core::extrapolated(mesh, levels);
        best->solver += fmt::format(", finest of {} meshes, extrapolated", levels.size());
        if (best->observed_error->relative_l2 <= refinement.goal)
            break;
    }
    if (!best) {
        best = std::move(levels.back());
        best->solver += fmt::format(", finest of {} meshes that have a solution", levels.size());
    }
    best->setup_seconds = setup_seconds;
    best->solve_seconds = solve_seconds;
    return std::move(*best);
}

} // namespace livermark::models
