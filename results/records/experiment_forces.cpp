#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

#include "core/units.hpp"
#include "results/records/experiment.hpp"

namespace livermark::results {

namespace {

/// Mean of the absolute errors; infinite where one is not known.
double mean_size(const std::vector<double> &errors) {
    double sum = 0.0;
    for (const double error : errors)
        sum += std::isfinite(error) ? std::abs(error) : HUGE_VAL;
    return sum / static_cast<double>(errors.size());
}

/// The factor of a force with which it is nearest to the measurement at all ways, and the root mean square of the
/// relative errors that are left.
struct BestModulus {
    double factor = std::numeric_limits<double>::quiet_NaN(), error = factor;
};
BestModulus best_modulus(const ForceResult &measured, const std::vector<double> &force) {
    double sum = 0.0, squares = 0.0;
    for (std::size_t j = 0; j < force.size(); ++j) {
        const double part = force[j] / measured.force[j];
        sum += part;
        squares += part * part;
    }
    const double factor = sum / squares; // of the least sum (factor part - 1)^2
    if (!std::isfinite(factor))
        return {};
    return {factor, std::sqrt(std::max(0.0, 1.0 - factor * sum / static_cast<double>(force.size())))};
}

/// A row of the table: a model on a mesh, or what needs none.
struct ShapeRow {
    std::string name;
    int tetrahedra = 0; ///< 0 of what needs no mesh
    core::SolutionStatus status = core::SolutionStatus::ok;
    std::vector<double> errors;
    double modulus = std::numeric_limits<double>::quiet_NaN(); ///< with which it is right at the first way [Pa]
    BestModulus best{};
    double seconds = 0.0;

    double size() const { return mean_size(errors); }
};

/// Rows without a mesh, in the order of the table.
std::vector<ShapeRow> nulls_of(const ForceResult &measured) {
    std::vector<ShapeRow> rows{{.name = "straight line", .errors = errors_of_shape(measured, measured.way)}};
    if (!measured.uniform.empty())
        rows.push_back({.name = "uniform body, neo-Hookean", .errors = errors_of_shape(measured, measured.uniform)});
    return rows;
}

std::vector<ShapeRow> models_of(const ForceResult &measured) {
    std::vector<ShapeRow> rows;
    for (const auto &run : measured.runs)
        rows.push_back({.name = run.model,
                        .tetrahedra = run.tetrahedra,
                        .status = run.status,
                        .errors = errors_of_shape(measured, run.force),
                        .modulus = measured.young_modulus * measured.force.front() / run.force.front(),
                        .best = best_modulus(measured, run.force),
                        .seconds = run.seconds});
    std::ranges::stable_sort(rows, {}, &ShapeRow::size);
    return rows;
}

std::string percent_cell(double part, bool is_signed) {
    if (!std::isfinite(part))
        return "-";
    return is_signed ? fmt::format("{:+.1f}", 100.0 * part) : fixed(100.0 * part, 1);
}

/// Largest distance between the errors of one model on two meshes; nothing where it has one.
std::vector<double> change_between_meshes(const ForceResult &measured, const std::string &model) {
    std::vector<std::vector<double>> found;
    for (const auto &run : measured.runs)
        if (run.model == model)
            found.push_back(errors_of_shape(measured, run.force));
    if (found.size() != 2)
        return {};
    std::vector<double> change;
    for (std::size_t j = 0; j < found[0].size(); ++j)
        change.push_back(std::abs(found[1][j] - found[0][j]));
    return change;
}

} // namespace

std::vector<double> errors_of_shape(const ForceResult &measured, const std::vector<double> &force) {
    std::vector<double> errors;
    for (std::size_t j = 1; j < measured.way.size(); ++j)
        errors.push_back(force[j] / force[0] * measured.force[0] / measured.force[j] - 1.0);
    return errors;
}

Layout force_table(const ExperimentResult &result) {
    Layout layout{{{"state"}, {"force"}, {"tetrahedra", true}}, {}};
    if (result.forces.empty())
        return layout;
    const auto &ways = result.forces.front().way;
    for (std::size_t j = 1; j < ways.size(); ++j)
        layout.columns.push_back({fmt::format("{:g} mm [%]", core::millimetres * ways[j]), true});
    layout.columns.push_back({fmt::format("modulus at {:g} mm [kPa]", core::millimetres * ways[0]), true});
    layout.columns.push_back({"modulus of all [kPa]", true});
    layout.columns.push_back({"error then [%]", true});
    layout.columns.push_back({"time [s]", true});
    for (const auto &measured : result.forces) {
        const auto add = [&](const ShapeRow &row, bool is_signed) {
            std::vector<std::string> cells{printable(measured.state),
                                           row.status == core::SolutionStatus::ok
                                               ? row.name
                                               : fmt::format("{} ({})", row.name, core::to_string(row.status)),
                                           row.tetrahedra > 0 ? std::to_string(row.tetrahedra) : ""};
            for (const double error : row.errors)
                cells.push_back(percent_cell(error, is_signed));
            cells.push_back(std::isfinite(row.modulus) ? fixed(1e-3 * row.modulus, 2) : "");
            const double kilopascals = 1e-3 * measured.young_modulus * row.best.factor;
            cells.push_back(std::isfinite(kilopascals) ? fixed(kilopascals, 2) : "");
            cells.push_back(std::isfinite(row.best.error) ? fixed(100.0 * row.best.error, 1) : "");
            cells.push_back(row.tetrahedra > 0 ? fixed(row.seconds, 1) : "");
            layout.rows.push_back(std::move(cells));
        };
        std::vector<double> spread;
        for (std::size_t j = 1; j < measured.way.size(); ++j)
            spread.push_back(measured.deviation[j] / measured.force[j]);
        if (std::ranges::any_of(spread, [](double part) { return part > 0.0; })) // unknown of one test
            add({.name = "standard deviation of the tests", .errors = spread}, false);
        if (const auto change = change_between_meshes(measured, result.reference); !change.empty())
            add({.name = "reference, uncertainty of its mesh", .errors = change}, false);
        for (const auto &row : nulls_of(measured))
            add(row, true);
        for (const auto &row : models_of(measured))
            add(row, true);
    }
    return layout;
}

std::vector<std::string> notes_on_nulls(const ExperimentResult &result) {
    std::vector<std::string> notes;
    const auto add = [&](const std::string &null, const std::string &state, const std::vector<std::string> &models) {
        if (!models.empty())
            notes.push_back(fmt::format("{}: {} knows no mechanics and is nearer to the measurement than {}",
                                        printable(state), null, fmt::join(models, ", ")));
    };
    for (std::size_t s = 0; s < result.states.size() && result.has_compared_markers(); ++s) {
        const auto &state = result.states[s];
        for (const auto &[null, error] : {std::pair{"the rigid motion that fits the markers", state.rigid_motion},
                                          {"the affine map that fits the markers", state.affine_map},
                                          {"the straight line", state.straight_line}}) {
            std::vector<std::string> models;
            for (const auto &run : result.runs)
                if (run.state == static_cast<int>(s) && error < run.error &&
                    std::ranges::find(models, run.model) == models.end())
                    models.push_back(run.model);
            add(null, state.name, models);
        }
    }
    for (const auto &measured : result.forces)
        for (const auto &null : nulls_of(measured)) {
            std::vector<std::string> models;
            for (const auto &row : models_of(measured))
                if (null.size() < row.size() && std::isfinite(row.size()) &&
                    std::ranges::find(models, row.name) == models.end())
                    models.push_back(row.name);
            add("the " + null.name, measured.state, models);
        }
    return notes;
}

} // namespace livermark::results
