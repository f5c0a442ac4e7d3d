#include "results/tables/table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/table_layout.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

using Row = std::vector<std::string>;

using core::millimetres;
using core::milliseconds;
using core::percent;
/// [m]; NaN if one displacement is NaN
double peak_displacement(const core::Solution &solution) {
    double peak = 0.0;
    for (const core::Vector3 &displacement : solution.displacement) {
        const double length = displacement.norm();
        if (std::isnan(length))
            return length;
        peak = std::max(peak, length);
    }
    return peak;
}

/// For the reference its own uncertainty, for the others a star if they are within it.
std::string uncertainty(const ModelResult &model, const Result &result) {
    const auto &known = result.reference_uncertainty;
    if (known && model.name == known->reference)
        return fixed(percent * known->relative_l2, 2);
    return is_within_uncertainty(model, result) ? "*" : "-";
}

/// Stiffness at the tool; of the reference how uncertain that is.
std::string tool_cell(const ModelResult &model, const Result &result) {
    if (const auto &known = result.reference_uncertainty; known && model.name == known->reference)
        return known->stiffness ? "+- " + fixed(percent * *known->stiffness, 1) : "-";
    return model.solution.status == core::SolutionStatus::ok ? stiffness_cell(stiffness_at_tool(model)) : "-";
}

Row error_row(const ModelResult &model, const Result &result, const std::string &body) {
    const core::Solution &solution = model.solution;
    const bool reference = is_reference(model, result);
    Row row{body,
            result.problem.load_case.name,
            reference ? model.name + " (reference)" : model.name,
            fixed(millimetres * peak_displacement(solution), 3),
            "-",
            uncertainty(model, result),
            tool_cell(model, result),
            "-",
            "-",
            "-",
            fixed(percent * solution.nonlinearity, 2),
            significant(solution.setup_seconds, 3),
            significant(solution.solve_seconds, 3),
            shown_status(model, result)};
    if (const auto &comparison = model.comparison) {
        row[4] = fixed(percent * comparison->relative_l2, 2);
        row[7] = fixed(millimetres * comparison->max_error, 3);
        if (const auto error = told_reaction_error(*comparison, result))
            row[8] = fixed(percent * *error, 2);
        if (!std::isnan(comparison->energy_error)) // who gives displacements alone says nothing of it
            row[9] = fmt::format("{}{}", comparison->energy_error > 0.0 ? "+" : "",
                                 fixed(percent * comparison->energy_error, 2));
    }
    return row;
}

std::string legend(std::span<const Result> results) {
    for (const Result &result : results)
        for (const ModelResult &model : result.models)
            if (is_within_uncertainty(model, result))
                return "\n*: errors below the reference's own uncertainty, which do not rank models\n";
    return "";
}

/// Meaning of the columns of the tool, and its size; nothing where there is none.
std::string tool_lines(std::span<const Result> results) {
    const auto radii = tool_radii(results);
    return radii.empty() ? "" : fmt::format("\n{}{}", tool_legend(), radii);
}

std::string describe(const std::string &model, const core::HistoryComparison &motion) {
    const double lag = std::round(10.0 * milliseconds * motion.lag) / 10.0;
    return fmt::format("{} {} % off {} (amplitude {:+.1f} %, {:.1f} ms {})", model,
                       fixed(percent * motion.relative_l2, 2), motion.reference, percent * motion.amplitude_error,
                       std::abs(lag), lag < 0.0 ? "early" : "late");
}

/// A line of the load cases whose loads are not those of their definition.
std::string load_scales(std::span<const Result> results) {
    std::vector<std::string> scales;
    for (const Result &result : results)
        if (const auto &load_case = result.problem.load_case; load_case.load_scale != 1.0)
            scales.push_back(fmt::format("{} {} {:.4g}", body_label(result, results), printable(load_case.name),
                                         load_case.load_scale));
    return scales.empty() ? "" : fmt::format("\nloads multiplied by: {}\n", fmt::join(scales, ", "));
}

std::string failures(std::span<const Result> results, const std::string &bullet) {
    std::string lines;
    for (const Result &result : results)
        for (const ModelResult &model : result.models)
            if (model.solution.status != core::SolutionStatus::ok)
                lines += fmt::format("{}{}, {}, {}: {}: {}\n", bullet, body_label(result, results),
                                     printable(result.problem.load_case.name), printable(model.name),
                                     core::to_string(model.solution.status), model.solution.message);
    return lines.empty() ? lines : fmt::format("\n{}", lines);
}

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

std::string motion_lines(std::span<const Result> results, const std::string &bullet) {
    std::string lines;
    for (const Result &result : results) {
        if (!result.problem.load_case.release)
            continue;
        std::vector<std::string> remarks;
        if (const auto &known = result.motion_uncertainty)
            remarks.push_back(fmt::format(
                "{} itself is uncertain by {}{} %{}", printable(known->reference),
                known->is_of_steps_alone() ? "more than " : "", fixed(percent * known->relative_l2, 2),
                known->is_of_steps_alone() ? ", which its steps cost alone: on no finer mesh its motion is known"
                                           : ""));
        for (const ModelResult &model : result.models)
            if (model.comparison && model.comparison->history)
                remarks.push_back(describe(printable(model.name), *model.comparison->history));
            else if (!model.solution.history)
                remarks.push_back(printable(model.name) + " gives no motion");
        lines += fmt::format("{}{}, {}: the rows are the {}; motion of the probes, relative L2 in time: {}\n", bullet,
                             body_label(result, results), printable(result.problem.load_case.name),
                             result.problem.load_case.slow_history ? "slow history before the release" : "static start",
                             fmt::join(remarks, ", "));
    }
    return lines.empty() ? lines : fmt::format("\n{}", lines);
}

std::string yielded_places(std::span<const Result> results) {
    std::vector<std::string> places;
    for (const Result &result : results)
        for (const auto &place : result.problem.load_case.yielded)
            places.push_back(fmt::format("{} {} '{}' {:.0f} %", body_label(result, results),
                                         printable(result.problem.load_case.name), printable(place.name),
                                         percent * place.lost_area));
    return places.empty() ? "" : fmt::format("\narea given up to other places: {}\n", fmt::join(places, ", "));
}

Layout error_table(std::span<const Result> results) {
    auto layout = headed({"body", "load case", "model"},
                         {"peak [mm]", "L2 [%]", "+- [%]", "tool [%]", "max [mm]", "react. [%]", "energy [%]",
                          "nonlin. [%]", "set-up [s]", "solve [s]"},
                         {"status"});
    for (const Result &result : results)
        for (const ModelResult &model : result.models)
            layout.rows.push_back(error_row(model, result, body_label(result, results)));
    return layout;
}

std::string text_table(std::span<const Result> results) {
    return to_text(error_table(results)) + legend(results) + tool_lines(results) + load_scales(results) +
           yielded_places(results) + motion_lines(results, "") + failures(results, "");
}

std::string markdown_table(std::span<const Result> results) {
    return to_markdown(error_table(results)) + legend(results) + tool_lines(results) + load_scales(results) +
           yielded_places(results) + motion_lines(results, "- ") + failures(results, "- ");
}

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

Layout modes_table(const Result &result, std::string_view reference) {
    const auto measure = std::ranges::find(result.modes, reference, &ModelModes::name);
    const auto is_compared = [&](const ModelModes &model) {
        return measure != result.modes.end() && model.name != measure->name;
    };
    Layout layout;
    layout.columns = {{"mode", true}};
    for (const auto &model : result.modes) {
        layout.columns.push_back({model.name + " [Hz]", true});
        if (is_compared(model)) {
            layout.columns.push_back({"error [%]", true});
            layout.columns.push_back({"MAC", true});
        }
    }
    for (int mode = 0; mode < result.modes.front().modes.count(); ++mode) {
        std::vector<std::string> row{std::to_string(mode + 1)};
        for (const auto &model : result.modes) {
            const double omega = model.modes.angular_frequency[mode];
            row.push_back(fixed(omega / (2.0 * std::numbers::pi), 4));
            if (is_compared(model)) {
                row.push_back(fixed(100.0 * (omega / measure->modes.angular_frequency[mode] - 1.0), 2));
                row.push_back(fixed(core::modal_assurance(result.problem.body->mesh, model.modes.shape_of(mode),
                                                          measure->modes.shape_of(mode)),
                                    3));
            }
        }
        layout.rows.push_back(std::move(row));
    }
    std::vector<std::string> seconds{"seconds"};
    for (const auto &model : result.modes) {
        seconds.push_back(fixed(model.modes.seconds, 2));
        if (is_compared(model))
            seconds.insert(seconds.end(), {"-", "-"});
    }
    layout.rows.push_back(std::move(seconds));
    return layout;
}

} // namespace livermark::results
