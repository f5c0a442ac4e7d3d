#include "results/tables/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
using core::milliseconds;
using core::percent;
/// Part of the critical step that runs take by default.
constexpr double safety_factor = 0.8;

std::string number(double value, double unit) {
    return significant(unit * value, 3);
}

/// Marks who is on the front of those of one body and load case.
std::vector<Standing> with_fronts(std::vector<Standing> standings) {
    for (auto &standing : standings) {
        // Itself first, so that its solution is the first.
        std::vector<CostAndError> group{standing.at};
        for (const auto &other : standings)
            if (other.is_ranked() && other.body == standing.body && other.load_case == standing.load_case &&
                other.reference == standing.reference)
                group.push_back(other.at);
        standing.is_on_front = standing.is_ranked() && pareto_front(group).front();
    }
    return standings;
}

/// The cells behind the names.
void add_numbers(std::vector<std::string> &row, const Standing &standing) {
    row.push_back(number(standing.time_step, milliseconds));
    row.push_back(number(standing.at.cost, 1.0));
    row.push_back(std::isnan(standing.at.error)
                      ? "-"
                      : over_some(fixed(percent * standing.at.error, 2), standing.num_cases, standing.num_in_table));
    row.emplace_back(standing.is_on_front ? "front" : "");
}

/// Seconds that a simulated second took, set-up left out.
double cost_of(const core::History &history) {
    return history.time.size() > 1 ? history.solve_seconds / history.time.back() : not_known;
}

/// Errors and costs of a model over the load cases of a body.
struct Moving {
    std::map<std::string, double> errors; ///< by load case, of which there may be several runs
    std::map<std::string, double> stiffness;
    bool has_failed = false;
    double critical_step = infinity, seconds_per_step = infinity; ///< of explicit steps
    double history_step = not_known, history_cost = not_known;
};

void enter(Moving &moving, const ModelResult &model, const Result &result) {
    const auto &solution = model.solution;
    if (counts_in_means(result)) {
        moving.has_failed |= solution.status != core::SolutionStatus::ok;
        if (model.comparison) {
            moving.errors[result.problem.load_case.name] = model.comparison->relative_l2;
            moving.stiffness[result.problem.load_case.name] = stiffness_at_tool(model);
        }
    }
    if (solution.explicit_steps) {
        moving.critical_step = std::min(moving.critical_step, solution.explicit_steps->critical_time_step);
        moving.seconds_per_step = std::min(moving.seconds_per_step, solution.explicit_steps->seconds_per_step);
    }
    if (solution.history) {
        moving.history_step = solution.history->time_step;
        moving.history_cost = cost_of(*solution.history);
    }
}

} // namespace

std::vector<bool> pareto_front(std::span<const CostAndError> points) {
    std::vector<bool> is_on_front;
    for (const auto &point : points)
        is_on_front.push_back(!std::isnan(point.cost) && !std::isnan(point.error) &&
                              std::ranges::none_of(points, [&](const CostAndError &other) {
                                  return other.cost <= point.cost && other.error <= point.error &&
                                         (other.cost < point.cost || other.error < point.error);
                              }));
    return is_on_front;
}

std::vector<Standing> standings_at_rest(std::span<const Result> results) {
    std::vector<Standing> standings;
    std::vector<Moving> moving;
    std::map<std::string, std::set<std::string>> in_table; // load cases that count, by body
    for (const auto &result : results) {
        const auto label = body_label(result, results);
        if (counts_in_means(result))
            in_table[label].insert(result.problem.load_case.name);
        for (const auto &model : result.models) {
            const auto found = std::ranges::find_if(standings, [&](const Standing &standing) {
                return standing.body == label && standing.model == model.name;
            });
            const auto at = found - standings.begin();
            if (found == standings.end()) {
                standings.push_back({.body = label,
                                     .load_case = {},
                                     .model = model.name,
                                     .integrator = {},
                                     .time_step = not_known,
                                     .at = {not_known, not_known},
                                     .is_on_front = false});
                moving.emplace_back();
            }
            enter(moving[at], model, result);
        }
    }
    std::vector<Standing> known;
    for (std::size_t i = 0; i < standings.size(); ++i) {
        const auto &model = moving[i];
        const bool is_explicit = std::isfinite(model.critical_step);
        auto &standing = standings[i];
        standing.time_step = is_explicit ? safety_factor * model.critical_step : model.history_step;
        standing.at.cost = is_explicit ? model.seconds_per_step / standing.time_step : model.history_cost;
        if (!model.has_failed && !model.errors.empty()) {
            standing.at.error = 0.0;
            standing.num_cases = model.errors.size();
            standing.num_in_table = in_table[standing.body].size();
            for (const auto &[load_case, error] : model.errors)
                standing.at.error += error / static_cast<double>(model.errors.size());
            StiffnessCases cases;
            for (const auto &[load_case, stiffness] : model.stiffness)
                cases.enter(stiffness, load_case);
            standing.stiffness = cases.mean();
        }
        if (!std::isnan(standing.at.cost))
            known.push_back(standing);
    }
    return with_fronts(std::move(known));
}

std::vector<Standing> standings_in_motion(std::span<const Result> results) {
    std::vector<Standing> standings;
    for (const auto &result : results)
        for (const auto &model : result.models)
            if (const auto &history = model.solution.history; history && model.comparison && model.comparison->history)
                standings.push_back(
                    {.body = body_label(result, results),
                     .load_case = result.problem.load_case.name,
                     .model = model.name,
                     .integrator = history->integrator,
                     .time_step = history->time_step,
                     .at = {cost_of(*history), model.comparison->history->relative_l2},
                     .is_on_front = false,
                     .uncertainty = result.motion_uncertainty && !result.motion_uncertainty->is_of_steps_alone()
                                        ? result.motion_uncertainty->relative_l2
                                        : not_known,
                     .reference = model.comparison->history->reference});
    return with_fronts(std::move(standings));
}

Layout static_accuracy(std::span<const Result> results) {
    auto layout = headed({"body", "model"}, {"step [ms]", "cost [s/s]", "mean error [%]", "mean tool [%]"}, {""});
    for (const auto &standing : standings_at_rest(results)) {
        auto &row = layout.rows.emplace_back(std::vector{standing.body, standing.model});
        add_numbers(row, standing);
        row.insert(row.end() - 1, size_cell(standing.stiffness));
    }
    return layout;
}

Layout motion_accuracy(std::span<const Result> results) {
    Layout layout{{{"body"},
                   {"load case"},
                   {"model"},
                   {"integrator"},
                   {"step [ms]", true},
                   {"cost [s/s]", true},
                   {"error [%]", true},
                   {""},
                   {"+- [%]", true},
                   {"against"}},
                  {}};
    for (const auto &standing : standings_in_motion(results)) {
        auto &row = layout.rows.emplace_back(
            std::vector{standing.body, standing.load_case, standing.model, standing.integrator});
        add_numbers(row, standing);
        row.push_back(number(standing.uncertainty, percent));
        row.push_back(standing.reference);
    }
    return layout;
}

} // namespace livermark::results
