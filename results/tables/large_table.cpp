#include "results/tables/large_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/tool/slow_response.hpp"
#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

using core::millimetres;
using core::percent;

/// With its sign.
std::string signed_percent(double value, int digits) {
    return std::isnan(value) ? "-" : fmt::format("{}{}", value > 0.0 ? "+" : "", fixed(percent * value, digits));
}

/// The farthest of the regions but the first, which is the liver around them; the reference's is known to be right.
std::string tumour_error(const core::PathComparison &path) {
    if (path.centroid_error.size() < 2)
        return "-";
    return fixed(millimetres * *std::max_element(path.centroid_error.begin() + 1, path.centroid_error.end()), 2);
}

/// Stiffness at the tool at the whole load and where it is worst along the path, and the error around the tool; of the
/// reference how uncertain the first is.
std::vector<std::string> cells_at_tool(const ModelResult &model, const Result &result) {
    if (const auto &known = result.reference_uncertainty; known && model.name == known->reference)
        return {known->stiffness ? "+- " + fixed(percent * *known->stiffness, 1) : "-", "-", "-"};
    if (!model.comparison || !model.comparison->tool || model.solution.status != core::SolutionStatus::ok)
        return {"-", "-", "-"};
    const auto &tool = *model.comparison->tool;
    const double error = tool.worst_place().relative_l2;
    return {stiffness_cell(tool.stiffness()), stiffness_cell(tool.worst_stiffness()), fixed(percent * error, 2)};
}

std::vector<std::string> large_row(const ModelResult &model, const Result &result, const std::string &body) {
    const auto &solution = model.solution;
    std::vector<std::string> row{body, result.problem.load_case.name,
                                 is_reference(model, result) ? model.name + " (reference)" : model.name};
    const auto &known = result.reference_uncertainty;
    const auto *path = model.comparison && model.comparison->path ? &*model.comparison->path : nullptr;
    if (path && solution.status == core::SolutionStatus::ok) {
        row.push_back(fixed(percent * model.comparison->relative_l2, 2));
        row.push_back(is_within_uncertainty(model, result) ? "within" : "-");
        row.push_back(fixed(percent * path->worst_relative_l2, 2));
        row.push_back(fixed(millimetres * path->percentile_95, 2));
        row.push_back(tumour_error(*path));
        row.push_back(signed_percent(path->reaction_bias, 1));
        row.push_back(fixed(percent * path->worst_reaction_error, 1));
    } else {
        row.insert(row.end(), 7, "-");
        if (known && model.name == known->reference)
            row[4] = fixed(percent * known->relative_l2, 2);
    }
    const auto at_tool = cells_at_tool(model, result);
    row.insert(row.begin() + 5, at_tool.begin(), at_tool.end());
    const auto deformed = core::deformation(result.problem.body->mesh, solution.displacement);
    row.push_back(signed_percent(deformed.volume_change, 2));
    row.push_back(fixed(deformed.smallest_jacobian, 2));
    row.push_back(fmt::format("{}", deformed.num_inverted));
    row.push_back(significant(solution.setup_seconds + solution.solve_seconds, 3));
    row.push_back(shown_status(model, result));
    return row;
}

/// The displacement that a constraint prescribes, mean over its facets, or to which a place or a ball presses; nothing
/// if it does not move, or not in one direction.
std::optional<core::Vector3> way_of(const core::LoadCase &load_case, const core::TetraMesh &mesh, int constraint) {
    if (const auto contact = load_case.contact(); contact && contact->constraint == constraint)
        return contact->pressed_at == 1.0 ? std::optional(contact->press) : std::nullopt;
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

/// Below this part of the largest response of a tool, the one at first is rounding.
constexpr double smallest_response = 1e-6;

std::string percent_cell(double value, int decimals) {
    return fixed(percent * value, decimals);
}

/// The record at which the whole load is first there.
std::size_t first_whole_load(const core::SlowHistory &history) {
    return static_cast<std::size_t>(std::ranges::max_element(history.factors) - history.factors.begin());
}

std::vector<std::string> slow_row(const ModelResult &model, const Result &result, const core::SlowResponse &response,
                                  const std::string &body) {
    const auto &load_case = result.problem.load_case;
    const auto &history = *load_case.slow_history;
    std::vector<std::string> row{
        body, load_case.name, is_reference(model, result) ? model.name + " (reference)" : model.name, response.place};
    if (response.values.size() == history.times.size()) {
        const double unit = response.is_force ? 1.0 : core::millimetres;
        const double first = response.values[first_whole_load(history)];
        const double largest =
            std::abs(*std::ranges::max_element(response.values, {}, [](double value) { return std::abs(value); }));
        const double last = response.values[static_cast<std::size_t>(history.whole_load_record())];
        row.push_back(significant(unit * first, 4) + (response.is_force ? " N" : " mm"));
        row.push_back(significant(unit * last, 4) + (response.is_force ? " N" : " mm"));
        row.push_back(std::abs(first) > smallest_response * largest ? percent_cell(last / first, 1) : "-");
    } else {
        row.insert(row.end(), 3, "-");
    }
    const auto *slow = model.comparison && model.comparison->slow ? &*model.comparison->slow : nullptr;
    row.push_back(slow ? percent_cell(slow->median_error, 2) : "-");
    row.push_back(slow ? percent_cell(slow->worst_error, 2) : "-");
    const double lost = core::lost_energy(history, model.solution);
    row.push_back(std::isnan(lost) ? "-" : significant(core::millijoules * lost, 4));
    row.push_back(slow ? percent_cell(slow->lost_energy, 1) : "-");
    row.push_back(fixed(model.solution.setup_seconds + model.solution.solve_seconds, 1));
    row.emplace_back(core::to_string(model.solution.status));
    return row;
}

} // namespace

Layout large_table(std::span<const Result> results) {
    auto layout =
        headed({"body", "load case", "model"},
               {"L2 [%]", "+- [%]", "tool [%]", "worst tool [%]", "tool L2 [%]", "worst L2 [%]", "95 % [mm]",
                "tumour [mm]", "force [%]", "worst react. [%]", "volume [%]", "min J", "inverted", "time [s]"},
               {"status"});
    for (const auto &result : results)
        for (const auto &model : result.models)
            layout.rows.push_back(large_row(model, result, body_label(result, results)));
    return layout;
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
    const auto listed = [](const std::vector<double> &values, double unit) {
        std::vector<std::string> words;
        for (const double value : values)
            words.push_back(significant(unit * value, 3));
        return fmt::format("{}", fmt::join(words, " "));
    };
    auto layout = headed({"body", "load case", "place", "model", "way [mm]", "force along it [N]"}, {});
    for (const auto &result : results)
        for (const auto &curve : force_curves(result))
            layout.rows.push_back({body_label(result, results), result.problem.load_case.name, curve.place, curve.model,
                                   listed(curve.way, millimetres), listed(curve.force, 1.0)});
    return layout;
}

Layout slow_table(std::span<const Result> results) {
    auto layout = headed({"body", "load case", "model", "tool"},
                         {"at first", "at last", "left [%]", "median error [%]", "worst error [%]", "heat [mJ]",
                          "its error [%]", "time [s]"},
                         {"status"});
    for (const auto &result : results)
        if (result.problem.load_case.slow_history)
            for (const auto &model : result.models)
                for (const auto &response :
                     core::slow_responses(result.problem.body->mesh, result.problem.load_case, model.solution))
                    layout.rows.push_back(slow_row(model, result, response, body_label(result, results)));
    return layout;
}

std::string slow_legend() {
    return "at first, at last: force of the tool along its way when the whole load is first there, and when it is last "
           "there (of a given traction: the displacement along it); left: the last of the first; errors: of that force "
           "at each time from that of the reference, over its largest, median and largest over the times; heat: energy "
           "that the body turns into heat in the last cycle, the work done less what is stored more at its end\n";
}

} // namespace livermark::results
