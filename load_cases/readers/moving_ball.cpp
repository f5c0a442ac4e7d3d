#include "load_cases/readers/moving_ball.hpp"

#include <fmt/format.h>
#include <utility>

#include "core/tool/tool_motion.hpp"
#include "load_cases/places/facets.hpp"
#include "load_cases/readers/lengths.hpp"
#include "load_cases/readers/touch_reader.hpp"
#include "support/input_error.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

namespace {

/// What is pushed, and how far at most.
struct PushedPlace {
    core::Vector3 middle = core::Vector3::Zero(), press = core::Vector3::Zero(); ///< [m]
};

PushedPlace pushed_place(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    PushedPlace place;
    double weight = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (load_case.constraint_on(f) != load_case.tool->constraint)
            continue;
        const auto &value = load_case.value[f];
        double factor = 0.0;
        for (const int node : mesh.boundary_triangles[f])
            factor += load_case.factor_at(node) / 3.0;
        const double here = factor * area_vector(mesh, f).norm();
        place.middle += here * facet_centroid(mesh, f);
        weight += here;
        if (value.norm() > place.press.norm())
            place.press = value;
    }
    if (!(weight > 0.0) || place.press.isZero(0.0))
        throw support::InputError(
            fmt::format("load case {}: the place of the tool is not pushed, so no ball can press there; give it a "
                        "'push' or another displacement",
                        load_case.name));
    place.middle /= weight;
    return place;
}

} // namespace

core::LoadCase with_touching_ball(core::LoadCase load_case, const core::TetraMesh &mesh, double friction) {
    auto table = support::parse_toml(load_case.definition, load_case.name + ".toml");
    bring_to_metres(table);
    const auto &tool = support::required_table(table, "tool");
    if (!tool.contains("radius"))
        throw support::InputError(fmt::format("load case {}: the [tool] has no radius, so it is not a ball that can "
                                              "touch; give it a 'radius' [m], or take --tool glued",
                                              load_case.name));
    const double radius = support::required_number(tool, "radius");
    const auto place = pushed_place(load_case, mesh);
    const core::TouchingTool ball{.radius = radius,
                                  .start = first_touch(mesh, place.middle, place.press.normalized(), radius).centre,
                                  .press = place.press,
                                  .friction = friction,
                                  .constraint = load_case.tool->constraint};
    auto touched = core::let_go(std::move(load_case));
    touched.node_factor.clear();
    touched.touching = ball;
    return touched;
}

} // namespace livermark::load_cases
