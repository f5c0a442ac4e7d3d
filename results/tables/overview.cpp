#include "results/tables/table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "results/one_reference.hpp"

namespace livermark::results {

namespace {

using core::microseconds;
using core::milliseconds;
using core::percent;

constexpr double infinity = std::numeric_limits<double>::infinity();
/// Part of the critical step that runs take by default.
constexpr double safety_factor = 0.8;

std::string smallest(const std::vector<double> &values, double unit) {
    return values.empty() ? "-" : fmt::format("{:.3g}", unit * *std::ranges::min_element(values));
}

/// NaN of none.
double largest(const std::vector<double> &values) {
    return values.empty() ? not_known : *std::ranges::max_element(values);
}

/// Errors and steps of one model on one body at one Poisson's ratio, over the load cases.
struct Cases {
    std::vector<double> errors, reaction_errors, uncertainties, critical_steps, step_seconds;
    StiffnessCases stiffness;
    std::string failure;          ///< a status other than ok
    std::size_t num_in_table = 0; ///< of all models: load cases that count

    bool has_ended() const { return failure.empty(); }
    bool is_reference() const { return errors.empty() && !uncertainties.empty(); }
    const std::vector<double> &shown() const { return is_reference() ? uncertainties : errors; }
    std::string sign() const { return is_reference() ? "+- " : ""; }
    std::string mean_cell() const {
        const auto error = fixed(percent * mean(shown()), 2);
        return !has_ended() || shown().empty() ? "-" : sign() + over_some(error, shown().size(), num_in_table);
    }
    std::string worst_cell() const { return has_ended() ? sign() + fixed(percent * largest(shown()), 2) : failure; }
    std::string mean_tool() const { return has_ended() ? stiffness.mean_cell() : "-"; }
    std::string worst_tool() const { return has_ended() ? stiffness.worst_cell() : "-"; }
    std::string mean_reaction() const { return fixed(percent * mean(reaction_errors), 2); }
    std::string worst_reaction() const { return fixed(percent * largest(reaction_errors), 2); }
    std::string step() const { return smallest(critical_steps, milliseconds); }
};

/// Cases of a model at each Poisson's ratio, or on each body.
struct CasesRow {
    std::string body, model;
    std::vector<Cases> cases{};
};

auto cell_at(std::size_t place, std::string (Cases::*cell)() const) {
    return [=](auto &row) { return (row.cases[place].*cell)(); };
}

void enter(Cases &cases, const ModelResult &model, const Result &result) {
    if (model.solution.status != core::SolutionStatus::ok) {
        cases.failure = core::to_string(model.solution.status);
    } else if (model.comparison) {
        cases.errors.push_back(model.comparison->relative_l2);
        cases.stiffness.enter(stiffness_at_tool(model), result.problem.load_case.name);
        if (const auto error = told_reaction_error(*model.comparison, result))
            cases.reaction_errors.push_back(*error);
    } else if (result.reference_uncertainty && result.reference_uncertainty->reference == model.name) {
        cases.uncertainties.push_back(result.reference_uncertainty->relative_l2);
    }
}

Cases collect(std::span<const Result> results, const std::string &body, double ratio, const std::string &name) {
    Cases cases;
    for (const auto &result : results)
        if (result.problem.body->name == body && poisson_ratio(result) == ratio)
            for (const auto &model : result.models)
                if (const auto &steps = model.solution.explicit_steps; steps && model.name == name) {
                    cases.critical_steps.push_back(steps->critical_time_step);
                    cases.step_seconds.push_back(steps->seconds_per_step);
                }
    cases.num_in_table = counted_load_cases(results, body, ratio).size();
    for (const auto &[model, result] : counted_cases(results, body, ratio, name))
        enter(cases, *model, *result);
    return cases;
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

auto significant_cell(double Standing::*value, double unit) {
    return [=](auto &standing) { return significant(unit * (standing.*value), 3); };
}

/// Columns of both tables.
void add_cost_and_error(TableOf<Standing> &table, const char *error_title) {
    table.number("step [ms]", significant_cell(&Standing::time_step, milliseconds));
    table.number("cost [s/s]", [](auto &standing) { return significant(standing.at.cost, 3); });
    table.number(error_title, [](auto &standing) {
        const auto error = fixed(percent * standing.at.error, 2);
        return std::isnan(standing.at.error) ? "-" : over_some(error, standing.num_cases, standing.num_in_table);
    });
}

void add_front(TableOf<Standing> &table) {
    table.text("", [](auto &standing) { return standing.is_on_front ? "front" : ""; });
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

void enter_moving(Moving &moving, const ModelResult &model, const Result &result) {
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

std::string body_label(const Result &result, std::span<const Result> all) {
    const auto &name = result.problem.body->name;
    const bool is_unique = std::ranges::all_of(all, [&](const Result &other) {
        return other.problem.body->name != name || poisson_ratio(other) == poisson_ratio(result);
    });
    return is_unique ? name : fmt::format("{}, nu {:g}", name, poisson_ratio(result));
}

std::vector<std::pair<std::string, std::string>> bodies_and_models(std::span<const Result> results,
                                                                   bool (*takes_part)(const Result &)) {
    std::vector<std::pair<std::string, std::string>> entries;
    for (const auto &result : results)
        for (const auto &model : result.models)
            if (const std::pair entry{result.problem.body->name, model.name};
                (!takes_part || takes_part(result)) && std::ranges::find(entries, entry) == entries.end())
                entries.push_back(entry);
    std::ranges::stable_sort(entries, {},
                             [](const auto &entry) { return std::pair(is_for_checks(entry.first), entry.first); });
    return entries;
}

bool is_for_checks(const std::string &body) {
    return body == "beam";
}

bool has_several_poisson_ratios(std::span<const Result> results) {
    return std::ranges::any_of(
        results, [&](const Result &result) { return body_label(result, results) != result.problem.body->name; });
}

std::optional<double> told_reaction_error(const core::Comparison &comparison, const Result &result) {
    const auto &load_case = result.problem.load_case;
    bool is_given = load_case.num_constraints() == 1;
    for (int facet = 0; facet < load_case.num_facets(); ++facet)
        if (load_case.constraint_on(facet) >= 0) {
            const auto &value = load_case.value[facet];
            is_given = is_given && !load_case.presses(facet) &&
                       std::ranges::none_of(value, [](double component) { return std::abs(component) > 0.0; });
        }
    return is_given || std::isnan(comparison.reaction_error) ? std::nullopt : std::optional(comparison.reaction_error);
}

Layout overview(std::span<const Result> results) {
    std::set<double> ratios;
    for (const auto &result : results)
        ratios.insert(poisson_ratio(result));
    std::vector<CasesRow> rows;
    for (const auto &[body, model] : bodies_and_models(results)) {
        auto &row = rows.emplace_back(CasesRow{body, model});
        for (const double ratio : ratios)
            row.cases.push_back(collect(results, body, ratio, model));
    }
    TableOf<CasesRow> table(std::move(rows));
    table.text("body", &CasesRow::body);
    table.text("model", &CasesRow::model);
    for (std::size_t r = 0; const double ratio : ratios) {
        const auto title = [&](const char *name) { return fmt::format("nu {:g}: {}", ratio, name); };
        table.number(title("mean [%]"), cell_at(r, &Cases::mean_cell));
        table.number(title("worst [%]"), cell_at(r, &Cases::worst_cell));
        table.number(title("mean tool [%]"), cell_at(r, &Cases::mean_tool));
        table.number(title("worst tool [%]"), cell_at(r, &Cases::worst_tool));
        table.number(title("mean react. [%]"), cell_at(r, &Cases::mean_reaction));
        table.number(title("worst react. [%]"), cell_at(r, &Cases::worst_reaction));
        table.number(title("step [ms]"), cell_at(r++, &Cases::step));
    }
    table.number("per step [us]", [](auto &row) {
        std::vector<double> seconds;
        for (const auto &cases : row.cases)
            std::ranges::copy(cases.step_seconds, std::back_inserter(seconds));
        return smallest(seconds, microseconds);
    });
    return table.layout();
}

Layout mean_errors(std::span<const Result> results) {
    std::vector<std::string> labels;
    std::vector<const Result *> first; // of each label
    std::vector<CasesRow> rows;
    for (const auto &result : results) {
        if (const auto label = body_label(result, results); std::ranges::find(labels, label) == labels.end()) {
            labels.push_back(label);
            first.push_back(&result);
        }
        for (const auto &model : result.models)
            if (std::ranges::find(rows, model.name, &CasesRow::model) == rows.end())
                rows.push_back({"", model.name});
    }
    for (auto &row : rows)
        for (const auto *result : first)
            row.cases.push_back(collect(results, result->problem.body->name, poisson_ratio(*result), row.model));
    TableOf<CasesRow> table(std::move(rows));
    table.text("model", &CasesRow::model);
    for (std::size_t b = 0; b < labels.size(); ++b) {
        table.number(labels[b] + " [%]", cell_at(b, &Cases::mean_cell));
        table.number(labels[b] + ": tool [%]", cell_at(b, &Cases::mean_tool));
    }
    return table.layout();
}

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
            const auto found = std::ranges::find_if(
                standings, [&](auto &standing) { return standing.body == label && standing.model == model.name; });
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
            enter_moving(moving[at], model, result);
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
    TableOf<Standing> table(standings_at_rest(results));
    table.text("body", &Standing::body);
    table.text("model", &Standing::model);
    add_cost_and_error(table, "mean error [%]");
    table.number("mean tool [%]", [](auto &standing) { return size_cell(standing.stiffness); });
    add_front(table);
    return table.layout();
}

Layout motion_accuracy(std::span<const Result> results) {
    TableOf<Standing> table(standings_in_motion(results));
    table.text("body", &Standing::body);
    table.text("load case", &Standing::load_case);
    table.text("model", &Standing::model);
    table.text("integrator", &Standing::integrator);
    add_cost_and_error(table, "error [%]");
    add_front(table);
    table.number("+- [%]", significant_cell(&Standing::uncertainty, percent));
    table.text("against", &Standing::reference);
    return table.layout();
}

} // namespace livermark::results
