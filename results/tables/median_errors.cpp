#include "results/tables/median_errors.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "results/quantile.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

using core::percent;
/// Part of a traction that may lie in the facet: nodes are rounded where they are written.
constexpr double largest_tangential_part = 1e-6;

/// Body, Poisson's ratio and load case.
using Key = std::tuple<std::string, double, std::string>;

bool has_pressure(const Result &result) {
    return is_pressure_on_whole_surface(result.problem.load_case, result.problem.body->mesh);
}

std::map<Key, const Result *> last_of_each(std::span<const Result> results) {
    std::map<Key, const Result *> last;
    for (const auto &result : results)
        if (is_plain_static(result))
            last[{result.problem.body->name, poisson_ratio(result), result.problem.load_case.name}] = &result;
    return last;
}

/// What there is of one model over some load cases.
struct MedianCases {
    std::vector<double> errors;
    std::vector<double> uncertainties;     ///< of the reference, where the model was compared with it
    std::vector<double> own_uncertainties; ///< where the model is the reference
    StiffnessCases stiffness;
    std::vector<double> own_stiffness; ///< how uncertain that is where the model is the reference
    std::string failure;               ///< a status other than ok
};

void enter_medians(MedianCases &cases, const ModelResult &model, const Result &result) {
    const auto &known = result.reference_uncertainty;
    if (model.solution.status != core::SolutionStatus::ok) {
        cases.failure = core::to_string(model.solution.status);
    } else if (model.comparison) {
        cases.errors.push_back(model.comparison->relative_l2);
        cases.stiffness.enter(stiffness_at_tool(model), result.problem.load_case.name);
        if (known)
            cases.uncertainties.push_back(known->relative_l2);
    } else if (known && known->reference == model.name) {
        cases.own_uncertainties.push_back(known->relative_l2);
        if (known->stiffness)
            cases.own_stiffness.push_back(*known->stiffness);
    }
}

std::string cell_of(const MedianCases &cases) {
    if (!cases.failure.empty())
        return cases.failure;
    if (!cases.errors.empty()) {
        const double error = median(cases.errors);
        const bool is_known = cases.uncertainties.size() == cases.errors.size();
        const bool is_within = is_known && error < median(cases.uncertainties);
        return fmt::format("{}{}", is_within ? "within " : "", fixed(percent * error, 2));
    }
    return cases.own_uncertainties.empty() ? "-" : "+- " + fixed(percent * median(cases.own_uncertainties), 2);
}

/// The median of stiffness at the tool.
std::string tool_cell_of(const MedianCases &cases) {
    if (cases.errors.empty() && !cases.own_stiffness.empty())
        return "+- " + fixed(percent * median(cases.own_stiffness), 1);
    return cases.failure.empty() ? cases.stiffness.median_cell() : "-";
}

/// Names of load cases, each once.
std::set<std::string> names_where(std::span<const Result> results, const std::function<bool(const Result &)> &is_one) {
    std::set<std::string> names;
    for (const auto &result : results)
        if (is_plain_static(result) && is_one(result))
            names.insert(result.problem.load_case.name);
    return names;
}

} // namespace

bool is_pressure_on_whole_surface(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    bool has_traction = false;
    for (int triangle = 0; triangle < mesh.num_boundary_triangles(); ++triangle) {
        if (load_case.condition[triangle] == core::FacetCondition::free)
            return false;
        if (load_case.condition[triangle] != core::FacetCondition::traction)
            continue;
        const auto &traction = load_case.value[triangle];
        const auto area = core::area_vector(mesh, triangle);
        if (traction.cross(area).norm() > largest_tangential_part * traction.norm() * area.norm())
            return false;
        has_traction = true;
    }
    return has_traction;
}

Layout median_errors(std::span<const Result> results) {
    const auto last = last_of_each(results);
    std::set<double, std::greater<>> ratios;
    for (const auto &result : results)
        if (is_plain_static(result))
            ratios.insert(poisson_ratio(result));
    Layout layout{{{"body"}, {"model"}}, {}};
    for (const double ratio : ratios)
        for (const auto *const title : {"median [%]", "tool [%]", "worst tool [%]", "pressure [%]"})
            layout.columns.push_back({fmt::format("nu {:g}: {}", ratio, title), true});
    for (const auto &[body, name] : bodies_and_models(results, is_plain_static)) {
        auto &row = layout.rows.emplace_back(std::vector{body, name});
        for (const double ratio : ratios) {
            MedianCases others, pressed;
            for (const auto &[key, result] : last)
                if (std::get<0>(key) == body && std::get<1>(key) == ratio)
                    for (const auto &model : result->models)
                        if (model.name == name)
                            enter_medians(has_pressure(*result) ? pressed : others, model, *result);
            row.push_back(cell_of(others));
            row.push_back(tool_cell_of(others));
            row.push_back(others.failure.empty() ? others.stiffness.worst_cell() : "-");
            row.push_back(cell_of(pressed));
        }
    }
    return layout;
}

bool has_several_load_cases(std::span<const Result> results) {
    std::map<std::pair<std::string, double>, int> numbers;
    for (const auto &[key, result] : last_of_each(results))
        if (++numbers[{std::get<0>(key), std::get<1>(key)}] > 1)
            return true;
    return false;
}

std::string median_legend(std::span<const Result> results) {
    const auto pressed = names_where(results, has_pressure);
    const auto others = names_where(results, [](const Result &result) { return !has_pressure(result); });
    std::string text;
    if (!others.empty())
        text += fmt::format("median: of the relative L2 errors under {}\n", fmt::join(others, ", "));
    if (!pressed.empty())
        text += fmt::format("pressure: the error under {}, with pressure on the whole free surface\n",
                            fmt::join(pressed, ", "));
    return text +
           "tool, worst tool: of the stiffness at the tool the median of absolute values, and the one farthest from "
           "zero with its load case\n" +
           tool_legend() +
           "+-: the reference's own uncertainty; within: closer to the reference than that, so not to be ranked "
           "above another such model\n";
}

} // namespace livermark::results
