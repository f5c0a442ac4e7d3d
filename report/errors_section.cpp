#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/models_of_results.hpp"
#include "report/sections.hpp"
#include "results/tables/overview.hpp"

namespace livermark::report {

namespace {

using core::percent;

/// Results of one body, a load case each.
std::vector<const results::Result *> cases_of(const ReportData &data, const std::string &label) {
    std::vector<const results::Result *> cases;
    for (const auto &result : data.results)
        if (results::body_label(result, data.results) == label)
            cases.push_back(&result);
    return cases;
}

std::string cell_of(const results::Result &result, const std::string &name) {
    const auto *model = find_model(result, name);
    if (!model)
        return "-";
    if (model->solution.status != core::SolutionStatus::ok)
        return core::to_string(model->solution.status);
    if (!model->comparison)
        return name == reference_of(result) ? "ref." : "not compared";
    return results::fixed(percent * model->comparison->relative_l2, 2) +
           (results::is_within_uncertainty(*model, result) ? " *" : "");
}

std::string uncertainty_cell(const results::Result &result) {
    return result.reference_uncertainty ? "± " + results::fixed(percent * result.reference_uncertainty->relative_l2, 2)
                                        : "not known";
}

bool is_spring_model_of(const std::vector<const results::Result *> &cases, const std::string &name) {
    return std::ranges::any_of(cases, [&](const results::Result *result) {
        const auto *model = find_model(*result, name);
        return model && is_spring_model(*model);
    });
}

/// A row for each model, a column for each load case, and the mean of those that came through all; the smallest of
/// what is no finite element is strong.
std::string table_of(const ReportData &data, const std::vector<const results::Result *> &cases) {
    results::Layout layout{{{"model"}}, {}};
    for (const auto *result : cases)
        layout.columns.push_back({result->problem.load_case.name, true});
    layout.columns.push_back({"mean", true});
    std::set<Cell> strong;
    double smallest_mean = std::numeric_limits<double>::infinity();
    std::optional<Cell> best_mean;
    for (const auto &name : model_names(data.results)) {
        std::vector<double> errors;
        std::vector<std::string> row{name};
        bool is_there = false;
        for (const auto *result : cases) {
            const auto *model = find_model(*result, name);
            is_there |= model != nullptr;
            row.push_back(cell_of(*result, name));
            if (model && std::isfinite(error_of(*model)))
                errors.push_back(error_of(*model));
            if (model && model == best_spring_model(*result))
                strong.insert({layout.rows.size(), row.size() - 1});
        }
        if (!is_there)
            continue;
        const bool has_mean = errors.size() == cases.size();
        if (has_mean && is_spring_model_of(cases, name) && mean(errors) < smallest_mean) {
            smallest_mean = mean(errors);
            best_mean = {layout.rows.size(), row.size()};
        }
        row.push_back(has_mean ? results::fixed(percent * mean(errors), 2) : "-");
        layout.rows.push_back(row);
    }
    if (best_mean)
        strong.insert(*best_mean);
    std::vector<std::string> last{"uncertainty of the reference"};
    for (const auto *result : cases)
        last.push_back(uncertainty_cell(*result));
    last.emplace_back("");
    layout.rows.push_back(last);
    return table_html(layout, strong);
}

std::vector<std::string> commands_of_cases(const std::vector<const results::Result *> &cases) {
    std::vector<std::string> commands;
    for (const auto *result : cases)
        commands.push_back(result->provenance.command);
    return commands;
}

std::string remarks(const std::vector<const results::Result *> &cases) {
    std::string html;
    std::vector<std::string> unsure;
    for (const auto *result : cases) {
        const auto &load_case = result->problem.load_case.name;
        if (!result->reference_uncertainty)
            unsure.push_back(load_case);
        for (const auto &model : result->models)
            if (model.solution.status != core::SolutionStatus::ok)
                html += missing(fmt::format("{}, {}: {}: {}", load_case, model.name,
                                            core::to_string(model.solution.status), model.solution.message));
    }
    if (!unsure.empty())
        html += missing(
            fmt::format("The uncertainty of the reference is unknown under {}: it was not solved on the refined "
                        "mesh.",
                        fmt::join(unsure, ", ")),
            "livermark run, without --no-uncertainty");
    return html;
}

} // namespace

std::string errors_section(const ReportData &data) {
    if (data.results.empty())
        return section("errors", "How far each model is off",
                       missing("There are no result files of small deformations here.", "livermark run"));
    auto html =
        paragraph("Relative L2 error of the displacement at rest against the reference, weighted by nodal volume. "
                  "The smallest error among the springs is in bold type, and so is their smallest mean. A star marks a "
                  "model that is closer to the reference than the uncertainty of the reference: such models are not "
                  "ranked. A load case with motion shows its static start here.");
    for (const auto &label : body_labels(data.results)) {
        const auto cases = cases_of(data, label);
        html +=
            subsection(label, figure("table matrix", table_of(data, cases),
                                     fmt::format("{}: error of each model under each load case [%], and uncertainty of "
                                                 "the reference.",
                                                 label),
                                     commands_of_cases(cases)) +
                                  remarks(cases));
    }
    return section("errors", "How far each model is off", html);
}

} // namespace livermark::report
