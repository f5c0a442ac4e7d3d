#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/models_of_results.hpp"
#include "report/sections.hpp"
#include "results/tables/large_table.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/summary.hpp"

namespace livermark::report {

namespace {

using core::millimetres;

/// Force against the way of each place that moves.
std::string forces_of(const results::Result &result, const std::vector<std::string> &all_models,
                      const std::string &label) {
    std::string html;
    const auto curves = results::force_curves(result);
    for (std::size_t first = 0; first < curves.size();) {
        Plot plot{.title = fmt::format("{}: {}", result.problem.load_case.name, curves[first].place),
                  .x = {.label = "way [mm]", .low = 0.0},
                  .y = {.label = "force [N]"},
                  .series = {},
                  .names = Names::key};
        auto last = first;
        for (; last < curves.size() && curves[last].place == curves[first].place; ++last) {
            const auto &curve = curves[last];
            Series series{.name = curve.model, .points = {{0.0, 0.0}}, .style = style_of(curve.model, all_models)};
            for (std::size_t k = 0; k < curve.force.size(); ++k)
                series.points.push_back({millimetres * curve.way * result.problem.load_case.path[k], curve.force[k]});
            plot.series.push_back(std::move(series));
        }
        html += figure("figure", plot_svg(plot),
                       fmt::format("{}, {}: force of each model on {} along its way.", label,
                                   result.problem.load_case.name, curves[first].place),
                       {result.provenance.command});
        first = last;
    }
    return html;
}

} // namespace

std::string large_section(const ReportData &data) {
    constexpr auto *title = "Deformations of surgical size";
    if (data.large.empty())
        return section(
            "large", title,
            missing("There are no result files of large deformations here.", "livermark run --regime large"));
    auto html = paragraph(results::large_legend()) +
                figure("table matrix", table_html(results::summary(data.large)),
                       "Relative L2 error of the displacement at the whole load [%], against hyperelastic elements.",
                       commands_of(data.large));
    const auto names = model_names(data.large);
    for (const auto &label : body_labels(data.large)) {
        std::vector<results::Result> of_body;
        std::string forces;
        for (const auto &result : data.large)
            if (results::body_label(result, data.large) == label) {
                of_body.push_back(result);
                forces += forces_of(result, names, label);
            }
        html += subsection(label, figure("table", table_html(results::large_table(of_body)),
                                         fmt::format("{}: every model under every large load case.", label),
                                         commands_of(of_body)) +
                                      forces);
    }
    return section("large", title, html);
}

} // namespace livermark::report
