#include "results/tables/table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "results/one_reference.hpp"

namespace livermark::results {

namespace {

using core::percent;
/// Part of a traction that may lie in the facet: nodes are rounded where they are written.
constexpr double largest_tangential_part = 1e-6;

bool has_pressure(const Result &result) {
    return is_pressure_on_whole_surface(result.problem.load_case, result.problem.body->mesh);
}

bool has_tool(const Result &result) {
    return !core::tool_places(result.problem.body->mesh, result.problem.load_case).empty();
}

/// A result for each load case that counts.
std::vector<const Result *> last_of_load_cases(std::span<const Result> results, const std::string &body, double ratio) {
    std::map<std::string, const Result *> last;
    for (const auto &result : results)
        if (result.problem.body->name == body && poisson_ratio(result) == ratio && counts_in_means(result))
            last[result.problem.load_case.name] = &result;
    std::vector<const Result *> found;
    for (const auto &[name, result] : last)
        found.push_back(result);
    return found;
}

/// Errors of one model over some load cases.
struct MedianCases {
    std::vector<double> errors;
    std::vector<double> uncertainties;     ///< of the reference, where the model was compared with it
    std::vector<double> own_uncertainties; ///< where the model is the reference
    StiffnessCases stiffness;
    std::vector<double> own_stiffness; ///< how uncertain that is where the model is the reference
    std::size_t num_with_tool = 0;     ///< load cases with one, of the same
    std::string failure;               ///< a status other than ok
    std::size_t num_in_table = 0;      ///< load cases, of all models
    bool has_springs = false;
};

/// With pressure on the whole surface, and all others.
struct CasesOfModel {
    MedianCases others, pressed;
};

void enter_medians(MedianCases &cases, const ModelResult &model, const Result &result) {
    cases.has_springs = cases.has_springs || model.solution.springs.has_value();
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
        if (known->stiffness || has_tool(result))
            ++cases.num_with_tool;
    }
}

std::string cell_of(const MedianCases &cases) {
    if (!cases.failure.empty())
        return cases.failure;
    if (!cases.errors.empty()) {
        const double error = median(cases.errors);
        const bool is_known = cases.uncertainties.size() == cases.errors.size();
        const bool is_of_all = cases.errors.size() == cases.num_in_table;
        const bool is_within = is_known && is_of_all && error < median(cases.uncertainties);
        return over_some(fixed(percent * error, 2), cases.errors.size(), cases.num_in_table) + (is_within ? " *" : "");
    }
    return cases.own_uncertainties.empty() ? "-"
                                           : "+- " + over_some(fixed(percent * median(cases.own_uncertainties), 2),
                                                               cases.own_uncertainties.size(), cases.num_in_table);
}

using CellOfStiffness = std::string (StiffnessCases::*)() const;

/// The median of stiffness at the tool. Not every reference has a bar of it.
std::string tool_cell_of(const MedianCases &cases, CellOfStiffness cell) {
    if (cases.errors.empty() && !cases.own_stiffness.empty())
        return "+- " + over_some(fixed(percent * median(cases.own_stiffness), 1), cases.own_stiffness.size(),
                                 cases.num_with_tool);
    return cases.failure.empty() ? (cases.stiffness.*cell)() : "-";
}

CasesOfModel cases_of_model(std::span<const Result> results, const std::string &body, double ratio,
                            const std::string &name) {
    CasesOfModel cases;
    const auto kind = [&](const Result &result) -> MedianCases & {
        return has_pressure(result) ? cases.pressed : cases.others;
    };
    for (const auto *const result : last_of_load_cases(results, body, ratio))
        ++kind(*result).num_in_table;
    for (const auto &[model, result] : counted_cases(results, body, ratio, name))
        enter_medians(kind(*result), *model, *result);
    return cases;
}

/// Names of load cases, each once.
std::set<std::string> names_where(std::span<const Result> results, const std::function<bool(const Result &)> &is_one) {
    std::set<std::string> names;
    for (const auto &result : results)
        if (counts_in_means(result) && is_one(result))
            names.insert(result.problem.load_case.name);
    return names;
}

/// A body at a Poisson's ratio.
struct BriefBody {
    std::string name;
    double poisson_ratio;
    std::string label;
};

std::vector<BriefBody> brief_bodies(std::span<const Result> results) {
    std::vector<BriefBody> bodies;
    std::set<std::string> known;
    for (const auto &result : results)
        if (counts_in_means(result))
            if (auto label = body_label(result, results); known.insert(label).second)
                bodies.push_back({result.problem.body->name, poisson_ratio(result), std::move(label)});
    std::ranges::stable_sort(bodies, {}, [](const BriefBody &body) { return is_for_checks(body.name); });
    return bodies;
}

/// In the order in which they appear, each once.
std::vector<std::string> brief_models(std::span<const Result> results) {
    std::vector<std::string> models;
    for (const auto &[body, model] : bodies_and_models(results, counts_in_means))
        if (std::ranges::find(models, model) == models.end())
            models.push_back(model);
    return models;
}

/// "nodal_springs 4.9 and 4.0 %, ..."
std::string listed(const BestSprings &best) {
    std::string text;
    for (const auto &[body, model, numbers] : best.models)
        text += fmt::format("{}{} {}{} %", text.empty() ? "" : ", ", model,
                            best.has_tools ? fixed(core::percent * numbers.median_stiffness, 1) + " and " : "",
                            fixed(core::percent * numbers.median_error, 1));
    return text;
}

} // namespace

bool is_pressure_on_whole_surface(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    bool has_traction = false;
    for (int triangle = 0; triangle < mesh.num_boundary_triangles(); ++triangle) {
        if (load_case.is_free(triangle))
            return false;
        if (!load_case.is_loaded(triangle))
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
    std::set<double, std::greater<>> ratios;
    for (const auto &result : results)
        if (counts_in_means(result))
            ratios.insert(poisson_ratio(result));
    struct Row {
        std::string body, model;
        std::vector<CasesOfModel> cases{}; ///< at each ratio
    };
    std::vector<Row> rows;
    for (const auto &[body, model] : bodies_and_models(results, counts_in_means)) {
        auto &row = rows.emplace_back(Row{body, model});
        for (const double ratio : ratios)
            row.cases.push_back(cases_of_model(results, body, ratio, model));
    }
    TableOf<Row> table(std::move(rows));
    table.text("body", &Row::body);
    table.text("model", &Row::model);
    for (std::size_t r = 0; const double ratio : ratios) {
        const auto number = [&](const char *name, auto cell) {
            table.number(fmt::format("nu {:g}: {}", ratio, name), [&](auto &row) { return cell(row.cases[r]); });
        };
        number("median [%]", [](auto &cases) { return cell_of(cases.others); });
        number("tool [%]", [](auto &cases) { return tool_cell_of(cases.others, &StiffnessCases::median_cell); });
        number("worst tool [%]",
               [](auto &cases) { return cases.others.failure.empty() ? cases.others.stiffness.worst_cell() : "-"; });
        number("pressure [%]", [](auto &cases) { return cell_of(cases.pressed); });
        ++r;
    }
    return table.layout();
}

double TwoNumbers::larger(bool has_tools) const {
    if (!has_tools || std::isnan(median_error))
        return median_error;
    return std::isnan(median_stiffness) ? median_stiffness : std::max(median_error, median_stiffness);
}

TwoNumbers two_numbers(std::span<const Result> results, const std::string &body, double poisson_ratio,
                       const std::string &model) {
    const auto cases = cases_of_model(results, body, poisson_ratio, model);
    const auto &counted = cases.others.num_in_table > 0 ? cases.others : cases.pressed;
    const auto median_or_none = [&](const std::vector<double> &values) {
        return values.empty() || !counted.failure.empty() ? not_known : median(values);
    };
    return {.error = cell_of(counted),
            .stiffness = tool_cell_of(counted, &StiffnessCases::signed_median_cell),
            .median_error = median_or_none(counted.errors),
            .median_stiffness = median_or_none(counted.stiffness.sizes),
            .is_spring_model = counted.has_springs};
}

bool has_several_load_cases(std::span<const Result> results) {
    return std::ranges::any_of(results, [&](const Result &result) {
        return counted_load_cases(results, result.problem.body->name, poisson_ratio(result)).size() > 1;
    });
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
           tool_legend() + "+-: the reference's own uncertainty; *: errors below it, which do not rank models\n";
}

std::vector<BriefNumbers> brief_numbers(std::span<const Result> results) {
    std::vector<BriefNumbers> all;
    const auto models = brief_models(results);
    for (const auto &body : brief_bodies(results))
        for (const auto &model : models)
            all.push_back({body.label, model, two_numbers(results, body.name, body.poisson_ratio, model)});
    return all;
}

Layout brief(std::span<const Result> results) {
    struct Row {
        std::string model;
        std::vector<TwoNumbers> numbers{}; ///< on each body
    };
    const auto bodies = brief_bodies(results);
    std::vector<Row> rows;
    for (const auto &model : brief_models(results)) {
        auto &row = rows.emplace_back(Row{model});
        for (const auto &body : bodies)
            row.numbers.push_back(two_numbers(results, body.name, body.poisson_ratio, model));
    }
    TableOf<Row> table(std::move(rows));
    table.text("model", &Row::model);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        table.number(bodies[b].label + ": L2 [%]", [=](auto &row) { return row.numbers[b].error; });
        table.number("tool [%]", [=](auto &row) { return row.numbers[b].stiffness; });
    }
    return table.layout();
}

std::vector<BestSprings> best_springs(std::span<const Result> results) {
    constexpr std::size_t most = 3;
    std::vector<BestSprings> all;
    const auto numbers = brief_numbers(results);
    for (const auto &body : brief_bodies(results)) {
        BestSprings best{.body = body.label, .models = {}};
        for (const auto &one : numbers)
            if (one.body == body.label && one.numbers.is_spring_model) {
                best.models.push_back(one);
                best.has_tools = best.has_tools || !std::isnan(one.numbers.median_stiffness);
            }
        const auto larger = [&](const BriefNumbers &one) { return one.numbers.larger(best.has_tools); };
        std::erase_if(best.models, [&](const BriefNumbers &one) { return std::isnan(larger(one)); });
        std::ranges::stable_sort(best.models, {}, larger);
        best.models.erase(best.models.begin() + static_cast<std::ptrdiff_t>(std::min(best.models.size(), most)),
                          best.models.end());
        if (!best.models.empty())
            all.push_back(std::move(best));
    }
    return all;
}

std::string brief_legend(std::span<const Result> results) {
    std::string text =
        "L2: error of the displacement over the whole body; both numbers are medians over load cases, of "
        "absolute values, and the tool has a sign where all load cases have the same\n" +
        tool_legend();
    for (const auto &best : best_springs(results))
        text += fmt::format("best springs on {}{}: {}\n", best.body,
                            best.has_tools ? ", by the larger of both numbers, under the tool and in position"
                                           : ", in position",
                            listed(best));
    return text;
}

} // namespace livermark::results
