#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/models_of_results.hpp"
#include "report/sections.hpp"
#include "results/tables/accuracy.hpp"
#include "results/tables/overview.hpp"

namespace livermark::report {

namespace {

using core::percent;

std::string group_of(const results::Standing &standing) {
    return standing.load_case.empty() ? standing.body : fmt::format("{}, {}", standing.body, standing.load_case);
}

/// Whether all that is known of a model in its group is by the same integrator.
bool is_moved_in_one_way(const results::Standing &standing, const std::vector<results::Standing> &standings) {
    return std::ranges::all_of(standings, [&](const results::Standing &other) {
        return other.model != standing.model || group_of(other) != group_of(standing) ||
               other.integrator == standing.integrator;
    });
}

/// The points of a group, and the front as a line behind them.
Plot plot_of(const std::string &group, const std::vector<results::Standing> &standings,
             const std::vector<std::string> &models, const std::string &error_label) {
    Plot plot{.title = group,
              .x = {.label = "seconds of one core for a simulated second", .scale = Scale::logarithmic},
              .y = {.label = error_label, .scale = Scale::logarithmic},
              .series = {}};
    Series front{.name = {}, .points = {}, .style = {"#b5bdc4", Marker::none, true, "3 3"}};
    std::vector<Series> points;
    for (const auto &standing : standings) {
        if (group_of(standing) != group)
            continue;
        const double error = percent * standing.at.error;
        if (standing.is_on_front)
            front.points.push_back({standing.at.cost, error});
        auto style = style_of(standing.model, models);
        style.has_line = false;
        const auto label = is_moved_in_one_way(standing, standings)
                               ? standing.model
                               : fmt::format("{}, {}", standing.model, standing.integrator);
        points.push_back({.name = {}, .points = {{standing.at.cost, error, label}}, .style = style});
    }
    std::ranges::sort(front.points, {}, &PlotPoint::x);
    plot.series.push_back(front);
    std::ranges::copy(points, std::back_inserter(plot.series));
    return plot;
}

std::string plots_of(const std::vector<results::Standing> &standings, const std::vector<std::string> &models,
                     const std::string &error_label) {
    std::vector<std::string> groups;
    for (const auto &standing : standings)
        if (std::ranges::find(groups, group_of(standing)) == groups.end())
            groups.push_back(group_of(standing));
    std::string html = "<div class=\"plots\">\n";
    for (const auto &group : groups)
        if (const auto plot = plot_of(group, standings, models, error_label); has_points(plot))
            html += plot_svg(plot);
    return html + "</div>\n";
}

} // namespace

std::string cost_section(const ReportData &data) {
    const auto models = model_names(data.results);
    const auto commands = commands_of(data.results);
    const auto at_rest = results::standings_at_rest(data.results);
    const auto in_motion = results::standings_in_motion(data.results);
    auto html = paragraph("Below and to the left is better. The dashed line joins the Pareto front: no other point has "
                          "a smaller error at the same cost. Costs are of one machine, in one run.");
    if (at_rest.empty())
        html += missing("No file here contains the time of a step.", "livermark run");
    else
        html += figure("figure", plots_of(at_rest, models, "mean error at rest [%]"),
                       "Mean error at rest over the load cases of each body, against the cost of a simulated second in "
                       "explicit steps of 0.8 of the critical one; for finite elements in the steps of their motion.",
                       commands) +
                figure("table", table_html(results::static_accuracy(data.results)), "The same in numbers.", {});
    if (in_motion.empty())
        html += missing("No model was moved, so there is no error in motion.", "livermark run --load-case release");
    else
        html += figure("figure", plots_of(in_motion, models, "error in motion [%]"),
                       "Error of the motion of the probes, against the cost of a simulated second.", commands) +
                figure("table", table_html(results::motion_accuracy(data.results)), "The same in numbers.", {});
    return section("cost", "Error against cost", html);
}

} // namespace livermark::report
