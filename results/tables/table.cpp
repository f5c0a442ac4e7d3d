#include "results/tables/table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

namespace {

using core::millimetres;
using core::milliseconds;
using core::percent;

/// A model under a load case. Pointers are null where it has no such part.
struct ModelRow {
    const ModelResult &model;
    const Result &result;
    std::string body; ///< body_label()

    const core::Solution &solution() const { return model.solution; }
    bool is_solved() const { return solution().status == core::SolutionStatus::ok; }
    double seconds() const { return solution().setup_seconds + solution().solve_seconds; }
    double nonlinearity() const { return solution().nonlinearity; }
    /// [m]; NaN if one displacement is NaN
    double peak() const {
        double peak = 0.0;
        for (const auto &displacement : solution().displacement)
            if (const double length = displacement.norm(); !(length <= peak))
                peak = std::isnan(peak) ? peak : length;
        return peak;
    }
    std::string status() const { return shown_status(model, result); }
    /// Uncertainty of the reference, of the reference itself.
    const ReferenceUncertainty *bar() const {
        const auto &known = result.reference_uncertainty;
        return known && model.name == known->reference ? &*known : nullptr;
    }
    /// With the uncertainty of the reference's displacement where others have a mark if they are within it.
    std::string bar_cell(const char *mark) const {
        return bar() ? fixed(percent * bar()->relative_l2, 2) : is_within_uncertainty(model, result) ? mark : "-";
    }
    std::string stiffness_bar() const { return bar()->stiffness ? "+- " + fixed(percent * *bar()->stiffness, 1) : "-"; }
    const core::Comparison *comparison() const { return model.comparison ? &*model.comparison : nullptr; }
    /// Comparison along the path, of a model that has come to an end.
    const core::PathComparison *path() const {
        return is_solved() && model.comparison && model.comparison->path ? &*model.comparison->path : nullptr;
    }
    const core::ToolComparison *tool() const {
        return is_solved() && model.comparison && model.comparison->tool ? &*model.comparison->tool : nullptr;
    }
    const core::SlowComparison *slow() const {
        return model.comparison && model.comparison->slow ? &*model.comparison->slow : nullptr;
    }
};

/// A number of a part that a row may have; NaN where it has none.
template <class Row, class Part, class Value> auto part_value(const Part *(Row::*part)() const, Value value) {
    return [=](auto &row) -> double {
        const auto *found = (row.*part)();
        return found ? std::invoke(value, *found) : not_known;
    };
}

std::vector<ModelRow> model_rows(std::span<const Result> results) {
    std::vector<ModelRow> rows;
    for (const auto &result : results)
        for (const auto &model : result.models)
            rows.push_back({model, result, body_label(result, results)});
    return rows;
}

template <class Row> void add_names(TableOf<Row> &table) {
    table.text("body", &Row::body);
    table.text("load case", [](auto &row) { return row.result.problem.load_case.name; });
    table.text("model",
               [](auto &row) { return row.model.name + (is_reference(row.model, row.result) ? " (reference)" : ""); });
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

/// All that stands below the table.
std::string notes(std::span<const Result> results, const std::string &bullet) {
    return legend(results) + tool_lines(results) + load_scales(results) + yielded_places(results) +
           motion_lines(results, bullet) + failures(results, bullet);
}

/// Appends what is not there yet.
template <class T> void note(std::vector<T> &seen, const T &value) {
    if (std::ranges::find(seen, value) == seen.end())
        seen.push_back(value);
}

/// A model on a body under all load cases.
struct SummaryRow {
    std::string body, model;
    std::vector<std::string> cells{}; ///< a load case each
    std::vector<double> errors{}, uncertainties{}, reactions{}, seconds{};
    StiffnessCases stiffness{};
    std::size_t num_in_table = 0; ///< load cases that count
};

void enter_load_case(SummaryRow &row, std::span<const Result> results, const std::string &load_case) {
    const auto append = [](std::vector<double> &values, const std::optional<double> &value) {
        values.insert(values.end(), value ? 1 : 0, value.value_or(0.0));
    };
    std::string cell = "-";
    bool any_counts = false;
    std::optional<double> error, at_tool, uncertainty, reaction; // of the last result
    for (const auto &result : results) {
        if (body_label(result, results) != row.body || result.problem.load_case.name != load_case)
            continue;
        const bool counts = counts_in_means(result);
        any_counts = any_counts || counts;
        const auto model = std::ranges::find(result.models, row.model, &ModelResult::name);
        if (model == result.models.end())
            continue;
        row.seconds.push_back(model->solution.solve_seconds);
        if (counts && result.reference_uncertainty && result.reference_uncertainty->reference == row.model)
            uncertainty = result.reference_uncertainty->relative_l2;
        if (model->solution.status != core::SolutionStatus::ok) {
            cell = core::to_string(model->solution.status);
        } else if (!model->comparison) {
            cell = reference_of(result) == row.model ? "reference" : shown_status(*model, result);
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
    row.cells.push_back(cell);
    row.num_in_table += any_counts ? 1 : 0;
    append(row.errors, error);
    append(row.uncertainties, uncertainty);
    append(row.reactions, reaction);
    if (at_tool)
        row.stiffness.enter(*at_tool, load_case);
}

/// The farthest of the regions but the first, which is the liver around them; the reference's is known to be right.
double tumour_error(const core::PathComparison &path) {
    const auto &errors = path.centroid_error;
    return errors.size() < 2 ? not_known : *std::max_element(errors.begin() + 1, errors.end());
}

/// The displacement that a constraint prescribes, mean over its facets, or to which a place or a ball presses; nothing
/// if it does not move, or not in one direction.
std::optional<core::Vector3> way_of(const core::LoadCase &load_case, const core::TetraMesh &mesh, int constraint) {
    for (const auto &contact : load_case.contacts())
        if (contact.constraint == constraint)
            return contact.pressed_at == 1.0 ? std::optional(contact.press) : std::nullopt;
    if (const core::Vector3 pressed = core::press_resultants(load_case, mesh)[constraint]; !pressed.isZero(0.0))
        return load_case.press_depth * pressed.normalized();
    core::Vector3 way = core::Vector3::Zero();
    int facets = 0;
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.constraint_on(f) == constraint) {
            for (int c = 0; c < 3; ++c)
                way[c] += std::isnan(load_case.value[f][c]) ? 0.0 : load_case.value[f][c];
            ++facets;
        }
    way /= std::max(facets, 1);
    return way.norm() > 0.0 ? std::optional(way) : std::nullopt;
}

/// The resultant of a pressure on a whole organ is rounding and the constrained part: a load has at least this part of
/// the sum of its sizes.
constexpr double least_resultant = 0.1;

/// Tractions that keep their direction, at the whole load.
struct DeadLoad {
    core::Vector3 resultant = core::Vector3::Zero(); ///< [N]
    double sum_of_sizes = 0.0;                       ///< sum of |force| over facets [N]
    std::vector<double> weight;                      ///< (N) of that, what each node of a facet takes [N]
};

DeadLoad dead_load(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    DeadLoad load;
    load.weight.assign(mesh.points.size(), 0.0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (!load_case.is_loaded(f) || load_case.follows_surface(f) || load_case.presses(f))
            continue;
        const core::Vector3 force = core::area_vector(mesh, f).norm() * load_case.value[f];
        const auto part = core::linear_parts(load_case.round_load_on(f), core::corners_of(mesh, f));
        for (std::size_t k = 0; k < 3; ++k)
            load.weight[mesh.boundary_triangles[f][k]] += part[k] * force.norm();
        load.resultant += force;
        load.sum_of_sizes += force.norm();
    }
    return load;
}

/// Part of the largest response of a tool below which the one at first is rounding.
constexpr double smallest_response = 1e-6;

/// The record at which the whole load is first there.
std::size_t first_whole_load(const core::SlowHistory &history) {
    return static_cast<std::size_t>(std::ranges::max_element(history.factors) - history.factors.begin());
}

/// A tool under a slow history.
struct SlowRow : ModelRow {
    core::SlowResponse response;

    bool is_whole() const { return response.values.size() == history().times.size(); }
    const core::SlowHistory &history() const { return *result.problem.load_case.slow_history; }
    double first() const { return response.values[first_whole_load(history())]; }
    double last() const { return response.values[static_cast<std::size_t>(history().whole_load_record())]; }
    double largest() const {
        return std::abs(*std::ranges::max_element(response.values, {}, [](double value) { return std::abs(value); }));
    }
    std::string with_units(double value) const {
        return response.is_force ? significant(value, 4) + " N" : significant(millimetres * value, 4) + " mm";
    }
};

/// A row of force_table().
struct ForceRow {
    std::string body, load_case;
    ForceCurve curve;
};

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
    using core::Comparison;
    TableOf<ModelRow> table(model_rows(results));
    add_names(table);
    table.number("peak [mm]", &ModelRow::peak, millimetres, 3);
    table.number("L2 [%]", part_value(&ModelRow::comparison, &Comparison::relative_l2), percent, 2);
    table.number("+- [%]", [](auto &row) { return row.bar_cell("*"); });
    table.number("tool [%]", [](auto &row) {
        return row.bar() ? row.stiffness_bar() : row.is_solved() ? stiffness_cell(stiffness_at_tool(row.model)) : "-";
    });
    table.number("max [mm]", part_value(&ModelRow::comparison, &Comparison::max_error), millimetres, 3);
    table.number("react. [%]", [](auto &row) {
        const auto error = row.comparison() ? told_reaction_error(*row.comparison(), row.result) : std::nullopt;
        return fixed(percent * error.value_or(not_known), 2);
    });
    table.signed_number("energy [%]", part_value(&ModelRow::comparison, &Comparison::energy_error), percent, 2);
    table.number("nonlin. [%]", &ModelRow::nonlinearity, percent, 2);
    table.number("set-up [s]", [](auto &row) { return significant(row.solution().setup_seconds, 3); });
    table.number("solve [s]", [](auto &row) { return significant(row.solution().solve_seconds, 3); });
    table.text("status", &ModelRow::status);
    return table.layout();
}

std::string text_table(std::span<const Result> results) {
    return to_text(error_table(results)) + notes(results, "");
}

std::string markdown_table(std::span<const Result> results) {
    return to_markdown(error_table(results)) + notes(results, "- ");
}

Layout summary(std::span<const Result> results) {
    std::vector<std::string> load_cases;
    std::vector<std::pair<std::string, std::string>> entries;
    for (const auto &result : results) {
        note(load_cases, result.problem.load_case.name);
        for (const auto &model : result.models)
            note(entries, {body_label(result, results), model.name});
    }
    std::vector<SummaryRow> rows;
    for (const auto &[body, model] : entries) {
        auto &row = rows.emplace_back(SummaryRow{body, model});
        for (const auto &load_case : load_cases)
            enter_load_case(row, results, load_case);
    }
    TableOf<SummaryRow> table(std::move(rows));
    table.text("body", &SummaryRow::body);
    table.text("model", &SummaryRow::model);
    for (std::size_t c = 0; c < load_cases.size(); ++c)
        table.number(load_cases[c] + " [%]", [=](auto &row) { return row.cells[c]; });
    table.number("mean [%]", [](auto &row) {
        const auto error = fixed(percent * mean(row.errors), 2);
        return row.errors.empty() ? "-" : over_some(error, row.errors.size(), row.num_in_table);
    });
    table.number("+- [%]", [](auto &row) { return fixed(percent * mean(row.uncertainties), 2); });
    table.number("tool [%]", [](auto &row) { return row.stiffness.mean_cell(); });
    table.number("worst tool [%]", [](auto &row) { return row.stiffness.worst_cell(); });
    table.number("react. [%]", [](auto &row) {
        return row.reactions.empty() ? "-" : fixed(percent * *std::ranges::max_element(row.reactions), 2);
    });
    table.number("solve [s]", [](auto &row) { return significant(mean(row.seconds), 2); });
    return table.layout();
}

Layout modes_table(const Result &result, std::string_view reference) {
    const auto measure = std::ranges::find(result.modes, reference, &ModelModes::name);
    const int count = result.modes.front().modes.count();
    const auto beside = [=](const std::string &last, auto cell) { // cells of modes, and one in the row of seconds
        return [=](int mode) { return mode < count ? std::string(cell(mode)) : last; };
    };
    std::vector<int> rows(static_cast<std::size_t>(count) + 1);
    std::iota(rows.begin(), rows.end(), 0);
    TableOf<int> table(std::move(rows));
    table.number("mode", beside("seconds", [](int mode) { return std::to_string(mode + 1); }));
    for (const auto &[name, modes] : result.modes) {
        const auto &omega = modes.angular_frequency;
        table.number(name + " [Hz]", beside(fixed(modes.seconds, 2), [&omega](int mode) {
                         return fixed(omega[mode] / (2.0 * std::numbers::pi), 4);
                     }));
        if (measure == result.modes.end() || name == measure->name)
            continue;
        const auto &shown = modes, &expected = measure->modes;
        table.number("error [%]", beside("-", [&](int mode) {
                         return fixed(100.0 * (omega[mode] / expected.angular_frequency[mode] - 1.0), 2);
                     }));
        table.number("MAC", beside("-", [&](int mode) {
                         return fixed(core::modal_assurance(result.problem.body->mesh, shown.shape_of(mode),
                                                            expected.shape_of(mode)),
                                      3);
                     }));
    }
    return table.layout();
}

Layout large_table(std::span<const Result> results) {
    using Path = core::PathComparison;
    const auto deformed = [](double core::Deformation::*value) {
        return [=](auto &row) {
            return core::deformation(row.result.problem.body->mesh, row.solution().displacement).*value;
        };
    };
    TableOf<ModelRow> table(model_rows(results));
    add_names(table);
    table.number("L2 [%]",
                 [](auto &row) { return row.path() ? fixed(percent * row.comparison()->relative_l2, 2) : "-"; });
    table.number("+- [%]", [](auto &row) { return row.bar_cell(row.path() ? "within" : "-"); });
    table.number("tool [%]", [](auto &row) {
        return row.bar() ? row.stiffness_bar() : row.tool() ? stiffness_cell(row.tool()->stiffness()) : "-";
    });
    table.number("worst tool [%]",
                 [](auto &row) { return row.tool() ? stiffness_cell(row.tool()->worst_stiffness()) : "-"; });
    table.number("tool L2 [%]", [](auto &row) {
        return row.tool() ? fixed(percent * row.tool()->worst_place().relative_l2, 2) : "-";
    });
    table.number("worst L2 [%]", part_value(&ModelRow::path, &Path::worst_relative_l2), percent, 2);
    table.number("95 % [mm]", part_value(&ModelRow::path, &Path::percentile_95), millimetres, 2);
    table.number("tumour [mm]", part_value(&ModelRow::path, tumour_error), millimetres, 2);
    table.signed_number("force [%]", part_value(&ModelRow::path, &Path::reaction_bias), percent, 1);
    table.number("worst react. [%]", part_value(&ModelRow::path, &Path::worst_reaction_error), percent, 1);
    table.signed_number("volume [%]", deformed(&core::Deformation::volume_change), percent, 2);
    table.number("min J", deformed(&core::Deformation::smallest_jacobian), 1.0, 2);
    table.number("inverted", [](auto &row) {
        const auto found = core::deformation(row.result.problem.body->mesh, row.solution().displacement);
        return fmt::format("{}", found.num_inverted);
    });
    table.number("time [s]", [](auto &row) { return significant(row.seconds(), 3); });
    table.text("status", &ModelRow::status);
    return table.layout();
}

std::string large_legend() {
    return "L2: of the displacement at the whole load, or at the part that the status names; tool: error of the "
           "stiffness at the tool (the tool is the place that the load case presses, pulls or moves; its stiffness is "
           "its force divided by its displacement), "
           "positive: stiffer than the reference; worst tool: the largest along the path; tool L2: of the displacement "
           "within two radii of the tool; !: above 7 %; worst L2: along the path; 95 %: nodal error that 95 % of the "
           "volume stay below; "
           "tumour: distance of a tumour's centroid from that of the reference; force: relative difference of the "
           "reactions; worst react.: error of the reactions along the path (fingers tell forces that differ by 7 %; "
           "Pang, Tan, Durlach 1991, Percept. Psychophys. 49(6)); min J: smallest ratio of current to initial volume "
           "of a tetrahedron; inverted: tetrahedra inside out\n";
}

std::vector<ForceCurve> force_curves(const Result &result) {
    const auto &load_case = result.problem.load_case;
    const auto &parts = load_case.load_parts();
    std::vector<ForceCurve> curves;
    for (int p = 0; p < load_case.num_constraints(); ++p)
        if (const auto way = way_of(load_case, result.problem.body->mesh, p))
            for (const auto &model : result.models) {
                auto &curve = curves.emplace_back(ForceCurve{load_case.constraint_names()[p], model.name, {}, {}});
                for (std::size_t k = 0; k < model.solution.path.size(); ++k) {
                    curve.way.push_back(parts[k] * way->norm());
                    curve.force.push_back(model.solution.path[k].reaction[p].dot(way->normalized()));
                }
            }
    const auto load = dead_load(load_case, result.problem.body->mesh);
    if (const double force = load.resultant.norm(); force > least_resultant * load.sum_of_sizes)
        for (const auto &model : result.models) {
            auto &curve = curves.emplace_back(ForceCurve{"load", model.name, {}, {}});
            for (std::size_t k = 0; k < model.solution.path.size(); ++k) {
                core::Vector3 mean = core::Vector3::Zero();
                for (std::size_t node = 0; node < load.weight.size(); ++node)
                    mean += load.weight[node] / load.sum_of_sizes *
                            model.solution.path[k].displacement[node].cast<double>();
                curve.way.push_back(mean.dot(load.resultant) / force);
                curve.force.push_back(parts[k] * force);
            }
        }
    return curves;
}

Layout force_table(std::span<const Result> results) {
    const auto listed = [](std::vector<double> ForceCurve::*values, double unit) {
        return [=](auto &row) {
            std::vector<std::string> words;
            for (const double value : row.curve.*values)
                words.push_back(significant(unit * value, 3));
            return fmt::format("{}", fmt::join(words, " "));
        };
    };
    std::vector<ForceRow> rows;
    for (const auto &result : results)
        for (auto &curve : force_curves(result))
            rows.push_back({body_label(result, results), result.problem.load_case.name, std::move(curve)});
    TableOf<ForceRow> table(std::move(rows));
    table.text("body", &ForceRow::body);
    table.text("load case", &ForceRow::load_case);
    table.text("place", [](auto &row) { return row.curve.place; });
    table.text("model", [](auto &row) { return row.curve.model; });
    table.text("way [mm]", listed(&ForceCurve::way, millimetres));
    table.text("force along it [N]", listed(&ForceCurve::force, 1.0));
    return table.layout();
}

Layout slow_table(std::span<const Result> results) {
    using Slow = core::SlowComparison;
    std::vector<SlowRow> rows;
    for (const auto &row : model_rows(results))
        if (const auto &load_case = row.result.problem.load_case; load_case.slow_history)
            for (const auto &response : core::slow_responses(row.result.problem.body->mesh, load_case, row.solution()))
                rows.push_back({row, response});
    const auto whole = [](auto cell) {
        return [=](auto &row) { return row.is_whole() ? std::string(cell(row)) : "-"; };
    };
    TableOf<SlowRow> table(std::move(rows));
    add_names(table);
    table.text("tool", [](auto &row) { return row.response.place; });
    table.number("at first", whole([](auto &row) { return row.with_units(row.first()); }));
    table.number("at last", whole([](auto &row) { return row.with_units(row.last()); }));
    table.number("left [%]", whole([](auto &row) {
                     return std::abs(row.first()) > smallest_response * row.largest()
                                ? fixed(percent * (row.last() / row.first()), 1)
                                : "-";
                 }));
    table.number("median error [%]", part_value(&ModelRow::slow, &Slow::median_error), percent, 2);
    table.number("worst error [%]", part_value(&ModelRow::slow, &Slow::worst_error), percent, 2);
    table.number("heat [mJ]", [](auto &row) {
        return significant(core::millijoules * core::lost_energy(row.history(), row.solution()), 4);
    });
    table.number("its error [%]", part_value(&ModelRow::slow, &Slow::lost_energy), percent, 1);
    table.number("time [s]", &SlowRow::seconds, 1.0, 1);
    table.text("status", [](auto &row) { return core::to_string(row.solution().status); });
    return table.layout();
}

std::string slow_legend() {
    return "at first, at last: force of the tool along its way when the whole load is first there, and when it is last "
           "there (of a given traction: the displacement along it); left: the last of the first; errors: of that force "
           "at each time from that of the reference, over its largest, median and largest over the times; heat: energy "
           "that the body turns into heat in the last cycle, the work done less what is stored more at its end\n";
}

} // namespace livermark::results
