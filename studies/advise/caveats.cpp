#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/mesh/plausible_liver.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "models/model_table.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "studies/advise/advise.hpp"

namespace livermark::studies {

namespace {

using core::millimetres;
using core::milliseconds;
using core::percent;

/// Below this many edges in its radius a mesh does not follow a tool (docs/studies/at_the_tool.md, "The radius of the
/// tool").
constexpr double fewest_edges_in_radius = 2.0;
/// A lump of fewer edges across has its stiffness from a few tetrahedra.
constexpr double fewest_edges_across = 3.0;
/// From here on the volume is a hundred times as stiff as the shape, lambda over mu.
constexpr double nearly_incompressible = 0.49;
constexpr double much_of_a_body = 0.05;
/// A step that stiff parts shorten by less is no caveat.
constexpr double little_shorter = 1.3;

using Caveats = std::vector<Caveat>;

void about_tool(const Advice &advice, Caveats &caveats) {
    const double edges = advice.body.tool_radius_in_edges();
    if (edges >= fewest_edges_in_radius)
        return;
    const double wanted = advice.body.tool_radius / fewest_edges_in_radius;
    const double count = advice.body.mesh.num_tetrahedra * std::pow(fewest_edges_in_radius / edges, 3.0);
    caveats.push_back(
        {"tool", 2.0 * fewest_edges_in_radius / edges,
         fmt::format(
             "A tool of {:.3g} mm radius has {:.1f} edges of this surface in its radius, and a mesh needs {:g} or "
             "more. That takes edges of {:.2g} mm where the tool presses; with them everywhere the mesh has about "
             "{:.0f} thousand tetrahedra.",
             millimetres * advice.body.tool_radius, edges, fewest_edges_in_radius, millimetres * wanted,
             std::ceil(count / 1000.0))});
}

/// Values of linear tetrahedra, in words; empty where they are not known.
std::string linear_words(const Advice &advice) {
    if (!advice.linear_tetrahedra || std::isnan(advice.linear_tetrahedra->at_tool))
        return {};
    return fmt::format("Linear tetrahedra lock at {:g}: they are {:.0f} % too stiff under such a tool.",
                       advice.evidence.poisson_ratio, percent * advice.linear_tetrahedra->at_tool);
}

void about_poisson_ratio(const Advice &advice, Caveats &caveats) {
    const auto &evidence = advice.evidence;
    const double ratio = advice.body.material().poisson_ratio;
    const double tolerance = 0.005;
    if (ratio > nearly_incompressible || ratio > evidence.largest_poisson_ratio + tolerance)
        caveats.push_back({"poisson_ratio", 6.0,
                           fmt::format("Poisson's ratio is {:g}, and errors are known up to {:g}: expect larger ones, "
                                       "shorter steps, and forces that are too large at the end of a press. {}",
                                       ratio, evidence.largest_poisson_ratio, linear_words(advice))});
    else if (ratio < evidence.least_poisson_ratio - tolerance)
        caveats.push_back({"poisson_ratio", 2.5,
                           fmt::format("Poisson's ratio is {:g}, and errors are known from {:g} on: below it models "
                                       "differ less, and springs without a volume term are right at 1/4 alone.",
                                       ratio, evidence.least_poisson_ratio)});
    else if (advice.linear_tetrahedra && advice.linear_tetrahedra->at_tool > core::smallest_felt_difference)
        caveats.push_back(
            {"poisson_ratio", 1.5, fmt::format("Poisson's ratio is {:g}. {}", ratio, linear_words(advice))});
}

void about_lesions(const Advice &advice, Caveats &caveats) {
    const RegionFigures *worst = nullptr;
    for (std::size_t r = 0; r < advice.body.regions.size(); ++r)
        if (const auto &region = advice.body.regions[r];
            r != advice.body.main_region && region.smallest_part_in_edges < fewest_edges_across &&
            (!worst || region.smallest_part_in_edges < worst->smallest_part_in_edges))
            worst = &region;
    if (worst)
        caveats.push_back(
            {"lesions", 2.0 * fewest_edges_across / worst->smallest_part_in_edges,
             fmt::format("The smallest part of region '{}' has {} tetrahedra and is {:.1f} edges across; below {:g} "
                         "the mesh determines its stiffness. Mesh it finer, or expect errors above and beside it.",
                         worst->name, worst->smallest_part_tetrahedra, worst->smallest_part_in_edges,
                         fewest_edges_across)});
}

void about_stiff_parts(const core::Body &body, const Advice &advice, double scaled, Caveats &caveats) {
    const auto &first = advice.touch.empty() ? advice.position.front() : advice.touch.front();
    const double longer = scaled / first.cost.critical_time_step;
    if (longer < little_shorter || msm::stiff_parts(body).empty())
        return;
    caveats.push_back(
        {"stiff_parts", 1.0 + longer,
         fmt::format(
             "Stiff regions shorten the critical step of {} to {:.3g} ms. Selective mass scaling makes it {:.3g} ms, "
             "{:.1f} times as long, and does not change equilibria (`livermark stability --mass-scaling`).",
             first.error.model, milliseconds * first.cost.critical_time_step, milliseconds * scaled, longer)});
}

void about_thin_parts(const Advice &advice, Caveats &caveats) {
    if (advice.body.thin_part > much_of_a_body)
        caveats.push_back({"thin_parts", 2.0 + 10.0 * advice.body.thin_part,
                           fmt::format("{:.0f} % of the volume is one layer of tetrahedra thick (all corners on the "
                                       "surface). Such parts bend too stiffly; errors were not observed on them.",
                                       percent * advice.body.thin_part)});
}

void about_short_edges(const Advice &advice, Caveats &caveats) {
    const auto &mesh = advice.body.mesh;
    const double part = mesh.shortest_edge / mesh.mean_edge, usual = 0.2;
    if (part < usual)
        caveats.push_back(
            {"short_edges", 1.0 + usual / part,
             fmt::format("The shortest edge is {:.2g} mm, {:.2f} of the mean, and the smallest quality of "
                         "a tetrahedron {:.2f}: a few such tetrahedra set the step of all nodes. Remesh "
                         "there.",
                         millimetres * mesh.shortest_edge, part, mesh.smallest_quality)});
}

void about_likeness(const core::Body &body, const Advice &advice, Caveats &caveats) {
    const auto &evidence = advice.evidence;
    if (!core::doubts_about_liver(body.mesh).empty())
        caveats.push_back({"not_a_liver", 3.0,
                           fmt::format("Errors were observed on livers of adults; this body of {:.3g} L is not one. "
                                       "Run `livermark run` on it before you rely on the ranking.",
                                       1e3 * advice.body.mesh.volume)});
    const double ratio = static_cast<double>(advice.body.mesh.num_tetrahedra) / evidence.tetrahedra;
    if (const double octaves = std::abs(std::log2(ratio)); octaves > 1.0)
        caveats.push_back(
            {"tetrahedra", octaves,
             fmt::format("Errors of the displacement were observed on about {} tetrahedra, and this body "
                         "has {}: expect {} ones.",
                         evidence.tetrahedra, advice.body.mesh.num_tetrahedra, ratio > 1.0 ? "smaller" : "larger")});
}

void about_material(const AdviceOptions &options, const Advice &advice, Caveats &caveats) {
    if (options.is_material_assumed)
        caveats.push_back(
            {"material", 3.5,
             fmt::format(
                 "The material of this body is not given; {:g} Pa and Poisson's ratio {:g} are assumed. Forces are "
                 "proportional to Young's modulus, and steps to one over its square root (--young, or a body .toml).",
                 advice.body.material().young_modulus, advice.body.material().poisson_ratio)});
}

/// What is true of every body, where nothing worse is.
void about_errors(const Advice &advice, Caveats &caveats) {
    const auto &first = advice.touch.empty() ? advice.position.front().error : advice.touch.front().error;
    if (std::isnan(first.large_at_tool))
        caveats.push_back(
            {"large_deformations", 2.0,
             fmt::format("Nothing is known of {} under loads of surgical size; run `livermark run --regime "
                         "large` on this body.",
                         first.model)});
    if (const auto *mixed = advice.evidence.find(models::static_reference(core::Regime::small).on_mesh))
        caveats.push_back(
            {"reference", 1.0,
             fmt::format("Quadratic elements with a pressure on such meshes are {:.1f} % off at the tool and {:.1f} % "
                         "in L2 themselves: smaller differences between models mean nothing.",
                         percent * mixed->at_tool, percent * mixed->relative_l2)});
}

} // namespace

std::vector<Caveat> find_caveats(const core::Body &body, const AdviceOptions &options, const Advice &advice,
                                 double scaled_time_step) {
    Caveats caveats;
    about_tool(advice, caveats);
    about_poisson_ratio(advice, caveats);
    about_lesions(advice, caveats);
    about_stiff_parts(body, advice, scaled_time_step, caveats);
    about_thin_parts(advice, caveats);
    about_short_edges(advice, caveats);
    about_likeness(body, advice, caveats);
    about_material(options, advice, caveats);
    about_errors(advice, caveats);
    std::ranges::stable_sort(caveats, std::ranges::greater(), &Caveat::weight);
    return caveats;
}

} // namespace livermark::studies
