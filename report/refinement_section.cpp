#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <map>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/models_of_results.hpp"
#include "report/sections.hpp"
#include "results/tables/overview.hpp"

namespace livermark::report {

namespace {

using core::millimetres;
using core::percent;

/// A name without its digits: what bodies have in common that differ in the size of their elements only.
std::string without_digits(std::string name) {
    std::erase_if(name, [](unsigned char c) { return std::isdigit(c) != 0; });
    return name;
}

double volume(const core::TetraMesh &mesh) {
    double sum = 0.0;
    for (const double one : core::tetrahedron_volumes(mesh))
        sum += one;
    return sum;
}

/// Edge of a cube of the mean volume of a tetrahedron [m].
double element_size(const core::TetraMesh &mesh) {
    return std::cbrt(volume(mesh) / mesh.num_tetrahedra());
}

/// Results of one family, load case and Poisson's ratio by the size of the elements.
using Family = std::map<double, const results::Result *>;

/// Those of which there are at least two sizes.
std::map<std::string, Family> families(const ReportData &data) {
    std::map<std::string, Family> all;
    for (const auto &result : data.results) {
        auto title = fmt::format("{}, {}", without_digits(result.problem.body->name), result.problem.load_case.name);
        if (results::has_several_poisson_ratios(data.results))
            title += fmt::format(", nu {:g}", poisson_ratio(result));
        all[title][element_size(result.problem.body->mesh)] = &result;
    }
    std::erase_if(all, [](const auto &family) { return family.second.size() < 2; });
    return all;
}

Plot plot_of(const std::string &title, const Family &family, const std::vector<std::string> &models) {
    Plot plot{.title = title,
              .x = {.label = "size of an element [mm]", .scale = Scale::logarithmic},
              .y = {.label = "error at rest [%]", .scale = Scale::logarithmic},
              .series = {},
              .width = 620.0};
    for (const auto &name : models) {
        Series series{.name = name, .points = {}, .style = style_of(name, models)};
        for (const auto &[size, result] : family)
            if (const auto *model = find_model(*result, name))
                series.points.push_back({millimetres * size, percent * error_of(*model)});
        plot.series.push_back(series);
    }
    return plot;
}

/// What refinement once changed in the reference, for each result that knows it.
std::string reference_table(const ReportData &data) {
    results::Layout layout{
        {{"body"}, {"load case"}, {"reference"}, {"change by refinement [%]", true}, {"uncertainty [%]", true}}, {}};
    for (const auto &result : data.results)
        if (const auto &known = result.reference_uncertainty)
            layout.rows.push_back({results::body_label(result, data.results), result.problem.load_case.name,
                                   known->reference, results::fixed(percent * known->refinement_difference, 2),
                                   results::fixed(percent * known->relative_l2, 2)});
    if (layout.rows.empty())
        return missing("The reference was solved on one mesh only, so its change by refinement is unknown.",
                       "livermark run, without --no-uncertainty");
    return figure("table", table_html(layout),
                  "The change of the reference when each tetrahedron is cut into eight, and the estimate of the error "
                  "that remains.",
                  commands_of(data.results));
}

} // namespace

std::string refinement_section(const ReportData &data) {
    std::string html, plots;
    const auto models = model_names(data.results);
    for (const auto &[title, family] : families(data))
        if (const auto plot = plot_of(title, family, models); has_points(plot))
            plots += plot_svg(plot);
    if (plots.empty())
        html += missing("There is no body with meshes of several sizes here, that is, bodies whose names differ in "
                        "digits only, such as "
                        "beam_kuhn_16mm and beam_kuhn_8mm.",
                        "scripts/mesh_study");
    else
        html +=
            figure("figure", "<div class=\"plots\">\n" + plots + "</div>\n",
                   "Error against the edge of a cube of the mean volume of a tetrahedron, of bodies whose names differ "
                   "in digits only.",
                   commands_of(data.results));
    if (!data.results.empty())
        html += reference_table(data);
    return section("refinement", "Error against refinement", html);
}

} // namespace livermark::report
