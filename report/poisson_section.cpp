#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/models_of_results.hpp"
#include "report/sections.hpp"
#include "results/tables/overview.hpp"

namespace livermark::report {

namespace {

using core::percent;

/// Results of one body by Poisson's ratio and load case.
using Cases = std::map<double, std::map<std::string, const results::Result *>>;

std::map<std::string, Cases> by_body(const ReportData &data) {
    std::map<std::string, Cases> bodies;
    for (const auto &result : data.results)
        bodies[result.problem.body->name][poisson_ratio(result)][result.problem.load_case.name] = &result;
    return bodies;
}

/// Only the same load cases can be compared over all ratios.
std::set<std::string> common_cases(const Cases &cases) {
    std::set<std::string> common;
    for (const auto &first : cases.begin()->second)
        if (std::ranges::all_of(cases, [&](const auto &at_ratio) { return at_ratio.second.contains(first.first); }))
            common.insert(first.first);
    return common;
}

Plot plot_of(const std::string &body, const Cases &cases, const std::set<std::string> &common,
             const std::vector<std::string> &models) {
    Plot plot{.title = body,
              .x = {.label = "Poisson's ratio"},
              .y = {.label = "mean error at rest [%]", .scale = Scale::logarithmic},
              .series = {},
              .width = 620.0};
    for (const auto &name : models) {
        Series series{.name = name, .points = {}, .style = style_of(name, models)};
        for (const auto &[ratio, by_name] : cases) {
            double sum = 0.0; // NaN if one is missing
            for (const auto &load_case : common) {
                const auto *model = find_model(*by_name.at(load_case), name);
                sum += model ? error_of(*model) : std::nan("");
            }
            series.points.push_back({ratio, percent * sum / static_cast<double>(common.size())});
        }
        plot.series.push_back(series);
    }
    return plot;
}

} // namespace

std::string poisson_section(const ReportData &data) {
    constexpr auto *title = "Error against Poisson's ratio";
    constexpr auto *command = "livermark run --static --poisson 0.25,0.45,0.49";
    if (!results::has_several_poisson_ratios(data.results))
        return section("poisson", title, missing("There is no body with several Poisson's ratios here.", command));
    const auto models = model_names(data.results);
    std::string html =
        paragraph("Central springs have a Poisson's ratio of 1/4, whatever the material says. A model that "
                  "failed in one of the load cases has no point there.");
    std::string plots;
    std::vector<std::string> remarks;
    for (const auto &[body, cases] : by_body(data)) {
        if (cases.size() < 2)
            continue;
        const auto common = common_cases(cases);
        if (common.empty()) {
            html += missing(fmt::format("{} has no load case that was run at each of its Poisson's ratios.", body));
            continue;
        }
        plots += plot_svg(plot_of(body, cases, common, models));
        remarks.push_back(fmt::format("{}: {}", body, fmt::join(common, ", ")));
    }
    if (!plots.empty())
        html += figure("figure", "<div class=\"plots\">\n" + plots + "</div>\n",
                       fmt::format("Mean error at rest over the load cases that were run at every ratio ({}).",
                                   fmt::join(remarks, "; ")),
                       commands_of(data.results));
    html += figure("table", table_html(results::mean_errors(data.results)),
                   "Mean error over all load cases of each body and ratio.", {});
    return section("poisson", title, html);
}

} // namespace livermark::report
