#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <string_view>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

constexpr const char *name_of_touch = "touch";
/// Distance at which the ball is said to touch the body, over its radius.
constexpr double nearly_touching = 1e-9;
constexpr int most_approaches = 10000;

double number_of_touch(const toml::table &touch, std::string_view key, bool may_be_zero) {
    const double value = support::required_number(touch, key);
    if (value < 0.0 || (value == 0.0 && !may_be_zero))
        support::refuse(*touch.get(key), "'{}' of a ball that touches is {}; it has to be {}", key, value,
                        may_be_zero ? "zero or more" : "positive");
    return value;
}

void refuse_company_of_touch(const Reading &reading) {
    const auto &[table, file, mesh, load_case] = reading;
    const auto &touch = support::required_table(table, "touch");
    std::vector<std::string_view> known{"radius", "depth", "friction", "slide"};
    std::ranges::transform(all_selectors(), std::back_inserter(known),
                           [](const Selector &selector) { return std::string_view(selector.name); });
    support::refuse_unknown_keys(touch, known);
    if (load_case.regime != core::Regime::large)
        support::refuse(touch,
                        "contact grows as a ball sinks in, which small deformations neglect; write regime = \"large\"");
    if (core::is_driven(load_case) || load_case.scale_to_target || table.contains("release") || table.contains("tool"))
        support::refuse(touch, "a ball that touches has to be the only load; leave out loads, accelerations, "
                               "displacements other than 0, 'scale_to_target', [release] and [tool]");
}

void read_touch(const Reading &reading) {
    const auto &[table, file, mesh, load_case] = reading;
    const auto &touch = support::required_table(table, "touch");
    const auto place = select_facets(touch, mesh, load_case);
    const Vector3 direction = -pressed_normal(place, mesh);
    if (!direction.allFinite())
        throw NotOnBody(support::place_of(touch),
                        fmt::format("the normals of '{}' cancel, so the ball has no direction", place.name),
                        "choose a smaller place");
    core::TouchingTool tool{.radius = number_of_touch(touch, "radius", false)};
    tool.press = number_of_touch(touch, "depth", false) * direction;
    if (touch.contains("friction"))
        tool.friction = number_of_touch(touch, "friction", true);
    if (touch.contains("slide"))
        tool.slide = support::required_vector(touch, "slide");
    if (tool.press.norm() > 2.0 * tool.radius)
        support::refuse(*touch.get("depth"),
                        "a ball that sinks in by {:g} m is under the surface, with a radius of {:g} m; give less depth "
                        "or a larger radius",
                        tool.press.norm(), tool.radius);
    const auto onto = nearest_point(place.facets, mesh, middle_of(place.facets, mesh)).point;
    const auto found = first_touch(mesh, onto, direction, tool.radius);
    if (load_case.is_constrained(found.facet))
        throw NotOnBody(support::place_of(touch), "the ball would first touch a constrained place",
                        "choose another place or a smaller ball");
    tool.start = found.centre;
    tool.constraint = load_case.num_constraints();
    load_case.conditions.push_back({name_of_touch, core::ConditionKind::touch});
    load_case.touching = tool;
}

} // namespace

FirstTouch first_touch(const core::TetraMesh &mesh, const Vector3 &onto, const Vector3 &direction, double radius) {
    FirstTouch ball{onto - (core::extent(mesh.points) + radius) * direction, -1};
    for (int approach = 0; approach < most_approaches; ++approach) {
        double distance = std::numeric_limits<double>::infinity();
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
            const double to_facet =
                (core::nearest_of_triangle(core::corners_of(mesh, f), ball.centre) - ball.centre).norm();
            if (to_facet < distance) {
                distance = to_facet;
                ball.facet = f;
            }
        }
        const double gap = distance - radius;
        if (gap < nearly_touching * radius)
            break;
        ball.centre += gap * direction;
    }
    return ball;
}

namespace events {

/// A rigid ball that touches.
EventReader touch() {
    return {.name = {},
            .what = "has a ball that touches",
            .folder = "load_cases/touching",
            .quantities = {.lengths = {"radius", "depth", "slide"}, .directions = {"slide"}, .has_place = true},
            .required = {"radius", "depth"},
            .refuse_company = refuse_company_of_touch,
            .read = read_touch};
}

} // namespace events

} // namespace livermark::load_cases
