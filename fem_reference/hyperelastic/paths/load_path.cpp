#include "fem_reference/hyperelastic/paths/load_path.hpp"

#include <chrono>
#include <fmt/format.h>
#include <utility>

#include "fem_reference/hyperelastic/one_process_system.hpp"
#include "fem_reference/hyperelastic/paths/equilibrium_search.hpp"

namespace livermark::hyperelastic {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Augments pressures until the ball sinks in no more than it may, or as often as it may.
/// @return false where an equilibrium is not found
bool settle(EquilibriumSearch &search, TouchingBall &ball, LoadedState &at, double fraction, FollowedPath &result) {
    const auto &settings = ball.settings();
    const auto centre = ball.tool().centre_at(fraction);
    const double most = settings.sunk_in * ball.tool().press.norm();
    for (int time = 0; time < settings.max_augmentations; ++time) {
        if (ball.sums(centre, at.state.displacement).sunk_in <= most)
            return true;
        ball.augment(centre, at.state.displacement);
        LoadStep step{.fraction = fraction, .converged = false, .residuals = {}, .linear_iterations = {}};
        const bool done = search.settle(at, step);
        result.steps.push_back(std::move(step));
        if (!done)
            return false;
    }
    return true;
}

} // namespace

FollowedPath follow(PathSystem &system, int num_constraints, const LoadPath &path) {
    FollowedPath result;
    EquilibriumSearch search(system, num_constraints, path, result);
    auto start = Clock::now();
    LoadedState at{system.rest()};
    const bool is_constrained = search.begin();
    result.setup_seconds = seconds_since(start);
    start = Clock::now();
    double reached = 0.0;
    if (!is_constrained) {
        result.status = core::SolutionStatus::not_converged;
        result.message = "the tangent stiffness at rest is singular: the prescribed displacements leave the body, or "
                         "a part of it, free to move as a rigid body; constrain it in all six ways";
        return result;
    }
    for (const double fraction : path.fractions) {
        const double way = fraction - reached;
        double length = way;
        while (reached < fraction) {
            // Not a step that leaves next to nothing for another.
            const double to = reached + 1.001 * length >= fraction ? fraction : reached + length;
            LoadStep step{.fraction = to, .converged = false, .residuals = {}, .linear_iterations = {}};
            const bool done = search.advance(at, reached, to, step);
            result.steps.push_back(std::move(step));
            if (done) {
                reached = to;
                constexpr std::size_t few = 6;
                if (result.steps.back().residuals.size() <= few)
                    length *= 2.0;
            } else {
                length = 0.5 * (to - reached);
                search.distrust_factor();
            }
            if (length < path.smallest_step * way) {
                result.status = core::SolutionStatus::not_converged;
                result.message = fmt::format(
                    "Newton's method finds no equilibrium beyond {:.1f} % of the load, in steps of {:.2f} % either: "
                    "the "
                    "body may buckle or fold there; take a smaller load, a finer mesh or constrain more of the body",
                    100.0 * reached, 100.0 * length);
                result.points.push_back(search.point(at, reached));
                result.solve_seconds = seconds_since(start);
                return result;
            }
        }
        if (system.ball() && !settle(search, *system.ball(), at, fraction, result)) {
            result.status = core::SolutionStatus::not_converged;
            result.message = fmt::format("Newton's method finds no equilibrium at {:.1f} % of the load with what the "
                                         "ball may sink in; take a finer mesh or a longer path",
                                         100.0 * fraction);
            result.points.push_back(search.point(at, fraction));
            result.solve_seconds = seconds_since(start);
            return result;
        }
        result.points.push_back(search.point(at, fraction));
        if (system.ball())
            system.ball()->end_step(system.ball()->tool().centre_at(fraction), at.state.displacement);
    }
    result.solve_seconds = seconds_since(start);
    return result;
}

FollowedPath follow(const Elements &elements, const fem_reference::DofConditions &conditions, int num_constraints,
                    std::span<const double> follower_pressure, const LoadPath &path, TouchingBall *ball) {
    OneProcessSystem system(elements, conditions, follower_pressure, ball);
    return follow(system, num_constraints, path);
}

} // namespace livermark::hyperelastic
