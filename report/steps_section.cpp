#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/plot.hpp"
#include "report/sections.hpp"
#include "results/tables/stability_table.hpp"

namespace livermark::report {

namespace {

using core::milliseconds;

/// Observed against predicted steps of all files: on the line they agree.
Plot plot_of(const std::vector<results::Stability> &all) {
    Plot plot{.title = "Longest stable step",
              .x = {.label = "predicted [ms]", .scale = Scale::logarithmic},
              .y = {.label = "observed [ms]", .scale = Scale::logarithmic},
              .series = {{.name = {}, .points = {}, .style = {"#b5bdc4", Marker::none, true, "3 3"}}}};
    const auto add = [&](const std::string &label, const results::StepLimit &limit, const char *colour, Marker marker) {
        if (!limit.has_number() || std::isnan(limit.observed))
            return;
        const double predicted = milliseconds * limit.predicted;
        plot.series.front().points.push_back({predicted, predicted});
        plot.series.push_back({.name = {},
                               .points = {{predicted, milliseconds * limit.observed, label}},
                               .style = {colour, marker, false}});
    };
    for (const auto &stability : all)
        for (const auto &limits : stability.limits) {
            const bool is_first = stability.body == all.front().body;
            const auto *const colour = is_first ? "#0072b2" : "#d55e00";
            add(limits.integrator, limits.undamped, colour, Marker::circle);
            add(limits.integrator + ", damped", limits.damped, colour, Marker::triangle);
        }
    std::ranges::sort(plot.series.front().points, {}, &PlotPoint::x);
    return plot;
}

} // namespace

std::string steps_section(const ReportData &data) {
    constexpr auto *title = "Time steps, predicted and observed";
    if (data.stability.empty())
        return section("steps", title, missing("There are no stability files here.", "livermark stability"));
    auto html = paragraph(
        "The longest stable step of an integrator is predicted from the largest frequency of the springs, and "
        "observed in runs of the nonlinear springs. None: without damping, oscillations grow at every "
        "step. Any: stable at every step. Not observed: just above the limit a motion grows too slowly "
        "to be seen in a run.");
    std::vector<std::string> commands;
    for (const auto &stability : data.stability) {
        commands.push_back(stability.provenance.command);
        html += subsection(
            stability.body,
            figure(
                "table", table_html(results::stability_table(stability)),
                fmt::format("{}, springs of {}, constrained as in {}: angular frequencies from {:.2f} to {:.2f} rad/s "
                            "(Gershgorin's bound: {:.2f} rad/s); damped with alpha = {:.4f} 1/s and beta = "
                            "{:.3e} s; the mean edge over the speed of sound is {:.3f} ms.",
                            stability.body, stability.spring_law, stability.load_case, stability.lowest_frequency,
                            stability.largest_frequency, stability.largest_frequency_bound, stability.damping.alpha,
                            stability.damping.beta, milliseconds * stability.element_time_step),
                {stability.provenance.command}));
    }
    if (const auto plot = plot_of(data.stability); has_points(plot))
        html += figure("figure", plot_svg(plot),
                       fmt::format("Observed against predicted steps; on the dashed line they agree. Blue: {}; orange: "
                                   "other bodies. Circles: without damping; triangles: with it.",
                                   data.stability.front().body),
                       commands);
    else
        html += missing("The steps were not observed in runs (--no-observed).");
    return section("steps", title, html);
}

} // namespace livermark::report
