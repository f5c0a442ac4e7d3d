#include "results/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <string>

#include "results/overview.hpp"

namespace livermark::results {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double percent = 100.0;
constexpr double milliseconds = 1e3;
/// Part of the critical step that runs take by default.
constexpr double safety_factor = 0.8;

/// A row whose last cells are to be filled in.
struct Entry {
    std::string group; ///< rows of one group have a front in common
    std::vector<std::string> cells;
    double time_step = nan; ///< [s]
    CostAndError at{nan, nan};
};

std::string number(double value, double unit) {
    return std::isnan(value) ? "-" : fmt::format("{:.3g}", unit * value);
}

void add_rows(Layout &layout, std::span<const Entry> entries) {
    for (const auto &entry : entries) {
        std::vector<CostAndError> group;
        for (const auto &other : entries)
            if (other.group == entry.group)
                group.push_back(other.at);
        // The entry first, so that its answer is the first.
        group.insert(group.begin(), entry.at);
        auto &row = layout.rows.emplace_back(entry.cells);
        row.push_back(number(entry.time_step, milliseconds));
        row.push_back(number(entry.at.cost, 1.0));
        row.push_back(std::isnan(entry.at.error) ? "-" : fixed(percent * entry.at.error, 2));
        row.emplace_back(pareto_front(group).front() ? "front" : "");
    }
}

/// Seconds that a simulated second took, set-up left out.
double cost_of(const core::History &history) {
    return history.time.size() > 1 ? history.solve_seconds / history.time.back() : nan;
}

/// What a model comes to over the load cases of a body.
struct Moving {
    std::map<std::string, double> errors; ///< by load case, of which there may be several runs
    bool has_failed = false;
    double critical_step = infinity, seconds_per_step = infinity; ///< of explicit steps
    double history_step = nan, history_cost = nan;
};

void enter(Moving &moving, const ModelResult &model, const std::string &load_case) {
    const auto &solution = model.solution;
    moving.has_failed |= solution.status != core::SolutionStatus::ok;
    if (model.comparison)
        moving.errors[load_case] = model.comparison->relative_l2;
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

Layout static_accuracy(std::span<const Result> results) {
    std::vector<Entry> entries;
    std::vector<Moving> moving;
    for (const auto &result : results)
        for (const auto &model : result.models) {
            const std::vector<std::string> cells{body_label(result, results), model.name};
            const auto found = std::ranges::find(entries, cells, &Entry::cells);
            const auto at = found - entries.begin();
            if (found == entries.end()) {
                entries.push_back({.group = cells[0], .cells = cells});
                moving.emplace_back();
            }
            enter(moving[at], model, result.problem.load_case.name);
        }
    std::vector<Entry> known;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const auto &model = moving[i];
        const bool is_explicit = std::isfinite(model.critical_step);
        auto &entry = entries[i];
        entry.time_step = is_explicit ? safety_factor * model.critical_step : model.history_step;
        entry.at.cost = is_explicit ? model.seconds_per_step / entry.time_step : model.history_cost;
        if (!model.has_failed && !model.errors.empty()) {
            entry.at.error = 0.0;
            for (const auto &[load_case, error] : model.errors)
                entry.at.error += error / static_cast<double>(model.errors.size());
        }
        if (!std::isnan(entry.at.cost))
            known.push_back(entry);
    }
    Layout layout{{{"body"}, {"model"}, {"step [ms]", true}, {"cost [s/s]", true}, {"mean error [%]", true}, {""}}, {}};
    add_rows(layout, known);
    return layout;
}

Layout motion_accuracy(std::span<const Result> results) {
    std::vector<Entry> entries;
    for (const auto &result : results)
        for (const auto &model : result.models)
            if (const auto &history = model.solution.history;
                history && model.comparison && model.comparison->history) {
                const auto label = body_label(result, results);
                const auto &load_case = result.problem.load_case.name;
                entries.push_back({.group = fmt::format("{}/{}", label, load_case),
                                   .cells = {label, load_case, model.name, history->integrator},
                                   .time_step = history->time_step,
                                   .at = {cost_of(*history), model.comparison->history->relative_l2}});
            }
    Layout layout{{{"body"},
                   {"load case"},
                   {"model"},
                   {"integrator"},
                   {"step [ms]", true},
                   {"cost [s/s]", true},
                   {"error [%]", true},
                   {""}},
                  {}};
    add_rows(layout, entries);
    return layout;
}

} // namespace livermark::results
