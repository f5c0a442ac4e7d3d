#include "results/tables/overview.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

using core::microseconds;
using core::milliseconds;
using core::percent;

/// Errors and steps of one model on one body at one Poisson's ratio, over the load cases.
struct Cases {
    std::vector<double> errors, reaction_errors, uncertainties, critical_steps, step_seconds;
    StiffnessCases stiffness;
    std::string failure;          ///< a status other than ok
    std::size_t num_in_table = 0; ///< of all models: load cases that count
};

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

std::string largest(const std::vector<double> &values) {
    return values.empty() ? "-" : fixed(percent * *std::ranges::max_element(values), 2);
}

std::string mean_in_percent(const std::vector<double> &values) {
    return values.empty() ? "-"
                          : fixed(percent * std::accumulate(values.begin(), values.end(), 0.0) /
                                      static_cast<double>(values.size()),
                                  2);
}

std::string smallest(const std::vector<double> &values, double unit) {
    return values.empty() ? "-" : fmt::format("{:.3g}", unit * *std::ranges::min_element(values));
}

std::vector<std::string> cells_of(const Cases &cases) {
    const bool is_reference = cases.errors.empty() && !cases.uncertainties.empty();
    const auto plus_minus = [&](const std::string &text) { return is_reference ? "+- " + text : text; };
    const auto &errors = is_reference ? cases.uncertainties : cases.errors;
    const auto mean = errors.empty() ? "-" : over_some(mean_in_percent(errors), errors.size(), cases.num_in_table);
    const bool has_ended = cases.failure.empty();
    return {has_ended ? plus_minus(mean) : "-",
            has_ended ? plus_minus(largest(errors)) : cases.failure,
            has_ended ? cases.stiffness.mean_cell() : "-",
            has_ended ? cases.stiffness.worst_cell() : "-",
            mean_in_percent(cases.reaction_errors),
            largest(cases.reaction_errors),
            smallest(cases.critical_steps, milliseconds)};
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
    std::ranges::stable_sort(entries, {}, &std::pair<std::string, std::string>::first);
    return entries;
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
    auto layout = headed({"body", "model"}, {});
    for (const double ratio : ratios)
        for (const auto *const title : {"mean [%]", "worst [%]", "mean tool [%]", "worst tool [%]", "mean react. [%]",
                                        "worst react. [%]", "step [ms]"})
            layout.columns.push_back({fmt::format("nu {:g}: {}", ratio, title), true});
    layout.columns.push_back({"per step [us]", true});
    for (const auto &[body, model] : bodies_and_models(results)) {
        auto &row = layout.rows.emplace_back(std::vector{body, model});
        std::vector<double> step_seconds;
        for (const double ratio : ratios) {
            const auto cases = collect(results, body, ratio, model);
            std::ranges::copy(cells_of(cases), std::back_inserter(row));
            std::ranges::copy(cases.step_seconds, std::back_inserter(step_seconds));
        }
        row.push_back(smallest(step_seconds, microseconds));
    }
    return layout;
}

Layout mean_errors(std::span<const Result> results) {
    auto layout = headed({"model"}, {});
    std::vector<std::string> labels, models;
    std::vector<const Result *> first; // of each label
    for (const auto &result : results) {
        if (const auto label = body_label(result, results); std::ranges::find(labels, label) == labels.end()) {
            labels.push_back(label);
            first.push_back(&result);
            layout.columns.push_back({label + " [%]", true});
            layout.columns.push_back({label + ": tool [%]", true});
        }
        for (const auto &model : result.models)
            if (std::ranges::find(models, model.name) == models.end())
                models.push_back(model.name);
    }
    for (const auto &model : models) {
        auto &row = layout.rows.emplace_back(std::vector{model});
        for (const auto *result : first) {
            const auto cells = cells_of(collect(results, result->problem.body->name, poisson_ratio(*result), model));
            row.insert(row.end(), {cells[0], cells[2]});
        }
    }
    return layout;
}

} // namespace livermark::results
