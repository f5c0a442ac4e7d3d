#include "results/tables/summary.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

using core::percent;

/// Appends what is not there yet.
template <class T> void note(std::vector<T> &seen, const T &value) {
    if (std::ranges::find(seen, value) == seen.end())
        seen.push_back(value);
}

void append(std::vector<double> &values, const std::optional<double> &value) {
    if (value)
        values.push_back(*value);
}

double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<std::string> row_of(std::span<const Result> results, const std::string &body, const std::string &name,
                                const std::vector<std::string> &load_cases) {
    std::vector<std::string> row{body, name};
    std::vector<double> errors, uncertainties, reactions, seconds;
    StiffnessCases stiffness;
    std::size_t num_in_table = 0; // load cases that count
    for (const auto &load_case : load_cases) {
        std::string cell = "-";
        bool any_counts = false;
        std::optional<double> error, at_tool, uncertainty, reaction; // of the last result
        for (const auto &result : results) {
            if (body_label(result, results) != body || result.problem.load_case.name != load_case)
                continue;
            const bool counts = counts_in_means(result);
            any_counts = any_counts || counts;
            const auto model = std::ranges::find(result.models, name, &ModelResult::name);
            if (model == result.models.end())
                continue;
            seconds.push_back(model->solution.solve_seconds);
            if (counts && result.reference_uncertainty && result.reference_uncertainty->reference == name)
                uncertainty = result.reference_uncertainty->relative_l2;
            if (model->solution.status != core::SolutionStatus::ok) {
                cell = core::to_string(model->solution.status);
            } else if (!model->comparison) {
                cell = reference_of(result) == name ? "reference" : shown_status(*model, result);
            } else {
                const double part = compared_part(result);
                cell = fixed(percent * model->comparison->relative_l2, 2) + (leaves_regime(result) ? " !" : "") +
                       (part < 1.0 ? fmt::format(" at {:.3g} %", percent * part) : "");
                if (!counts)
                    continue;
                error = model->comparison->relative_l2;
                at_tool = stiffness_at_tool(*model);
                reaction = told_reaction_error(*model->comparison, result);
            }
        }
        num_in_table += any_counts ? 1 : 0;
        append(errors, error);
        if (at_tool)
            stiffness.enter(*at_tool, load_case);
        append(uncertainties, uncertainty);
        append(reactions, reaction);
        row.push_back(cell);
    }
    row.push_back(errors.empty() ? "-" : over_some(fixed(percent * mean(errors), 2), errors.size(), num_in_table));
    row.push_back(uncertainties.empty() ? "-" : fixed(percent * mean(uncertainties), 2));
    row.push_back(stiffness.mean_cell());
    row.push_back(stiffness.worst_cell());
    row.push_back(reactions.empty() ? "-" : fixed(percent * *std::ranges::max_element(reactions), 2));
    row.push_back(significant(mean(seconds), 2));
    return row;
}

} // namespace

Layout summary(std::span<const Result> results) {
    std::vector<std::string> load_cases;
    std::vector<std::pair<std::string, std::string>> entries;
    for (const auto &result : results) {
        note(load_cases, result.problem.load_case.name);
        for (const auto &model : result.models)
            note(entries, {body_label(result, results), model.name});
    }
    Layout layout;
    layout.columns = {{"body"}, {"model"}};
    for (const auto &load_case : load_cases)
        layout.columns.push_back({load_case + " [%]", true});
    for (const auto *const title : {"mean [%]", "+- [%]", "tool [%]", "worst tool [%]", "react. [%]", "solve [s]"})
        layout.columns.push_back({title, true});
    for (const auto &[body, model] : entries)
        layout.rows.push_back(row_of(results, body, model, load_cases));
    return layout;
}

} // namespace livermark::results
