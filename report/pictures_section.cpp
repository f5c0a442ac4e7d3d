#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

#include "core/bounding_box.hpp"
#include "core/units.hpp"
#include "report/colour_map.hpp"
#include "report/html.hpp"
#include "report/models_of_results.hpp"
#include "report/sections.hpp"
#include "report/surface_picture.hpp"
#include "report/ticks.hpp"

namespace livermark::report {

namespace {

using core::Vector3;

using core::millimetres;
using core::percent;
constexpr int picture_width = 460;
/// Part of the size of the body that its largest displacement is drawn as.
constexpr double drawn_part = 0.08;
/// Part of the size of the body that has to move for a picture of it.
constexpr double least_drawn = 1e-9;
/// How far beyond the end of a scale one has to be to be mentioned.
constexpr double beyond = 1.02;
constexpr const char *simplest = "lloyd";

std::vector<double> lengths(const std::vector<Vector3> &vectors) {
    std::vector<double> all;
    for (const auto &vector : vectors)
        all.push_back(vector.norm());
    return all;
}

double largest(const std::vector<Vector3> &vectors) {
    return std::ranges::max(lengths(vectors));
}

/// A round number by which displacements are drawn longer, at least 1.
double exaggeration(const core::TetraMesh &mesh, double peak) {
    return std::max(1.0, 1.0 / rounded_up(peak / (drawn_part * core::extent(mesh.points))));
}

std::vector<Vector3> moved(const core::TetraMesh &mesh, const std::vector<Vector3> &displacement, double factor) {
    auto points = mesh.points;
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] += factor * displacement[i];
    return points;
}

/// Whether it has lengths that can be drawn: a file may hold anything, whatever it says of itself.
bool can_be_drawn(const std::vector<Vector3> &field, const core::TetraMesh &mesh) {
    const double longest_drawn = 100.0 * core::extent(mesh.points);
    return std::ranges::all_of(field, [&](const Vector3 &vector) { return vector.norm() < longest_drawn; });
}

/// The nearest of the springs and Lloyd's, or whoever is there.
std::vector<const results::ModelResult *> models_to_show(const results::Result &result) {
    std::vector<const results::ModelResult *> shown;
    const auto show = [&](const results::ModelResult *model) {
        if (model && std::isfinite(error_of(*model)) && std::ranges::find(shown, model) == shown.end() &&
            can_be_drawn(model->solution.displacement, result.problem.body->mesh) &&
            can_be_drawn(model->comparison->error, result.problem.body->mesh))
            shown.push_back(model);
    };
    show(best_spring_model(result));
    show(find_model(result, simplest));
    for (const auto &model : result.models)
        if (shown.empty())
            show(&model);
    return shown;
}

/// Everything that the pictures of one result have in common.
struct Scene {
    const core::TetraMesh &mesh;
    View view;
    Outline at_rest;
    double displacement_scale, error_scale; ///< lengths of the last colours [m]
    std::string what;                       ///< body and load case
};

std::string picture(const Scene &scene, const std::vector<Vector3> &points, const std::vector<Vector3> &field,
                    Quantity quantity, const std::string &of, const std::string &title, const std::string &detail) {
    const auto values = lengths(field);
    const double scale = quantity == Quantity::error ? scene.error_scale : scene.displacement_scale;
    const auto drawn =
        draw_surface({scene.mesh.boundary_triangles, points, values, scale, quantity}, scene.view, scene.at_rest);
    return fmt::format("<div>{}{}<span>{}</span></div>\n",
                       image(png_bytes(drawn), drawn.width, drawn.height,
                             fmt::format("{}: {} from 0 to {:.3g} mm", scene.what, of, millimetres * scale)),
                       name_html(title), escaped(detail));
}

std::string pictures_of(const results::Result &result, const results::ModelResult &reference,
                        const std::vector<const results::ModelResult *> &models) {
    const auto &mesh = result.problem.body->mesh;
    const auto &displacement = reference.solution.displacement;
    const double peak = largest(displacement);
    // By the largest of all: springs that buckle would fill the picture otherwise.
    double longest = peak;
    for (const auto *model : models)
        longest = std::max(longest, largest(model->solution.displacement));
    const double factor = exaggeration(mesh, longest);
    std::vector<std::vector<Vector3>> shapes{mesh.points, moved(mesh, displacement, factor)};
    double worst = 0.0;
    for (const auto *model : models) {
        shapes.push_back(moved(mesh, model->solution.displacement, factor));
        worst = std::max(worst, largest(model->comparison->error));
    }
    const auto view = find_view(mesh.boundary_triangles, mesh.points, displacement, shapes, picture_width);
    const Scene scene{.mesh = mesh,
                      .view = view,
                      .at_rest = outline_of(mesh.boundary_triangles, mesh.points, view),
                      .displacement_scale = peak,
                      // Errors beyond the displacement itself would leave no colours to the other model.
                      .error_scale = worst > 0.0 ? std::min(worst, peak) : peak,
                      .what = fmt::format("{} under {}", result.problem.body->name, result.problem.load_case.name)};
    std::string html = "<div class=\"pictures\">\n";
    html += picture(scene, shapes[1], displacement, Quantity::displacement, "displacement of " + reference.name,
                    reference.name, fmt::format("reference, up to {:.3f} mm", millimetres * peak));
    for (std::size_t m = 0; m < models.size(); ++m)
        html += picture(scene, shapes[m + 2], models[m]->solution.displacement, Quantity::displacement,
                        "displacement of " + models[m]->name, models[m]->name,
                        fmt::format("up to {:.3f} mm", millimetres * largest(models[m]->solution.displacement)));
    if (models.size() == 1)
        html += "<div></div>\n"; // so that errors stand below displacements
    html += fmt::format("<div class=\"legend\">{}{}</div>\n",
                        colour_bar(Quantity::displacement, scene.displacement_scale, "displacement [mm]"),
                        colour_bar(Quantity::error, scene.error_scale, "error [mm]"));
    for (std::size_t m = 0; m < models.size(); ++m)
        html += picture(scene, shapes[m + 2], models[m]->comparison->error, Quantity::error,
                        "error of " + models[m]->name, "error of " + models[m]->name,
                        fmt::format("{:.2f} %, up to {:.3f} mm", percent * models[m]->comparison->relative_l2,
                                    millimetres * models[m]->comparison->max_error));
    html += "</div>\n";
    return figure(
        "figure", html,
        fmt::format("{}: {}{}. Displacements drawn {} the surface; the line is the outline at rest.{}", scene.what,
                    result.problem.load_case.title, result.problem.load_case.release ? " (the static start)" : "",
                    factor > 1.0 ? fmt::format("{:g} times as long on", factor) : "as long as they are on",
                    std::max(worst, longest) > beyond * peak ? " Values beyond a scale have its last colour." : ""),
        {result.provenance.command});
}

std::string part_of(const results::Result &result) {
    const auto title = fmt::format("{}, {}", result.problem.body->name, result.problem.load_case.name);
    const auto *reference = find_model(result, reference_of(result));
    const auto models = models_to_show(result);
    if (!reference || models.empty())
        return subsection(title, missing("No model was compared with a reference here, so there is nothing to show."));
    const auto &mesh = result.problem.body->mesh;
    if (!can_be_drawn(reference->solution.displacement, mesh) ||
        largest(reference->solution.displacement) < least_drawn * core::extent(mesh.points))
        return subsection(title, missing("The reference does not move, or has diverged."));
    return "<div class=\"case\">\n" + subsection(title, pictures_of(result, *reference, models)) + "</div>\n";
}

/// For each body the Poisson's ratio that most of its results have; of several such ratios the largest.
std::map<std::string, double> shown_ratios(const ReportData &data) {
    std::map<std::string, std::map<double, int>> counts;
    for (const auto &result : data.results)
        ++counts[result.problem.body->name][poisson_ratio(result)];
    std::map<std::string, double> ratios;
    for (const auto &[body, by_ratio] : counts) {
        int most = 0;
        for (const auto &[ratio, count] : by_ratio)
            if (count >= most) {
                most = count;
                ratios[body] = ratio;
            }
    }
    return ratios;
}

} // namespace

std::string pictures_section(const ReportData &data) {
    constexpr auto *title = "What it looks like";
    if (data.results.empty())
        return section("pictures", title,
                       missing("There are no result files of small deformations here.", "livermark run"));
    auto html =
        paragraph("Each load case: the reference, the nearest of the springs, and Lloyd's springs, which are the "
                  "simplest; below them the distance of each from the reference. All displacements of a load case have "
                  "one scale of colours, and so have all errors, in other colours.");
    const auto ratios = shown_ratios(data);
    std::vector<std::string> chosen;
    for (const auto &[body, ratio] : ratios)
        chosen.push_back(fmt::format("{} at Poisson's ratio {:g}", body, ratio));
    html += paragraph(fmt::format("Shown: {}.", fmt::join(chosen, ", ")));
    for (const auto &result : data.results)
        if (poisson_ratio(result) == ratios.at(result.problem.body->name))
            html += part_of(result);
    return section("pictures", title, html);
}

} // namespace livermark::report
