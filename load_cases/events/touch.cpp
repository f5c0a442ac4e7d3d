#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <string_view>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/touching_tool.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

constexpr const char *name_of_touch = "touch", *name_of_other_jaw = "other jaw";
/// Distance at which the ball is said to touch the body, over its radius.
constexpr double nearly_touching = 1e-9;
constexpr int most_approaches = 10000;
/// Radius of the edges of a plate over its size, where none is given: chosen so that a round plate has the force of one
/// with sharp edges within a hundredth at a depth of a hundredth of its size (tests `Punch.*`).
constexpr double usual_edge_radius = 0.1;
constexpr int most_parts = 16; ///< of a side of a facet, which make points a quarter of a millimetre apart on livers

double number_of_touch(const toml::table &touch, std::string_view key, bool may_be_zero) {
    const double value = support::required_number(touch, key);
    if (value < 0.0 || (value == 0.0 && !may_be_zero))
        support::refuse(*touch.get(key), "'{}' of a tool that touches is {}; it has to be {}", key, value,
                        may_be_zero ? "zero or more" : "positive");
    return value;
}

void refuse_company_of_touch(const Reading &reading) {
    const auto &[table, file, mesh, load_case] = reading;
    const auto &touch = support::required_table(table, "touch");
    support::refuse_unknown_keys(
        touch, keys_with_place({"radius", "plate", "size", "edge_radius", "depth", "friction", "slide", "jaws"}));
    if (load_case.regime != core::Regime::large)
        support::refuse(touch,
                        "contact grows as a ball sinks in, which small deformations neglect; write regime = \"large\"");
    if (core::is_driven(load_case) || load_case.scale_to_target || table.contains("release") || table.contains("tool"))
        support::refuse(touch, "a ball that touches has to be the only load; leave out loads, accelerations, "
                               "displacements other than 0, 'scale_to_target', [release] and [tool]");
}

/// Centre of the jaw that comes from the other side, where it just touches the body [m].
Vector3 start_of_other_jaw(const toml::table &touch, const core::LoadCase &load_case, const core::TetraMesh &mesh,
                           const Vector3 &onto, const core::TouchingTool &tool) {
    if (tool.shape.is_plate() || !tool.slide.isZero(0.0))
        support::refuse(*touch.get("jaws"), "jaws are two balls that close; {}",
                        tool.shape.is_plate() ? "give a 'radius' in place of the plate" : "leave out 'slide'");
    const Vector3 direction = tool.press.normalized();
    const auto other = first_touch(mesh, onto, -direction, tool.shape);
    if (load_case.is_constrained(other.facet))
        throw NotOnBody(support::place_of(touch), "the other jaw would first touch a constrained place",
                        "choose another place or smaller jaws");
    const double thickness = (other.centre - tool.start).dot(direction) - 2.0 * tool.shape.radius;
    if (2.0 * tool.press.norm() >= thickness)
        throw NotOnBody(support::place_of(touch),
                        fmt::format("the body is {:.3g} m thick there, and jaws that sink in by {:g} m each would meet",
                                    thickness, tool.press.norm()),
                        "give less depth or choose a thicker place");
    return other.centre;
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
    core::TouchingTool tool;
    tool.press = number_of_touch(touch, "depth", false) * direction;
    tool.shape = tool_shape(touch, tool.press);
    if (touch.contains("friction"))
        tool.friction = number_of_touch(touch, "friction", true);
    if (touch.contains("slide"))
        tool.slide = support::required_vector(touch, "slide");
    if (tool.press.norm() > 2.0 * tool.shape.reach())
        support::refuse(*touch.get("depth"),
                        "a {} that sinks in by {:g} m is under the surface, with a radius of {:g} m; give less depth "
                        "or a larger {}",
                        tool.shape.is_plate() ? "plate" : "ball", tool.press.norm(), tool.shape.reach(),
                        tool.shape.is_plate() ? "size" : "radius");
    const auto onto = nearest_point(place.facets, mesh, middle_of(place.facets, mesh)).point;
    const auto found = first_touch(mesh, onto, direction, tool.shape);
    if (load_case.is_constrained(found.facet))
        throw NotOnBody(support::place_of(touch), "the tool would first touch a constrained place",
                        "choose another place or a smaller tool");
    tool.start = found.centre;
    tool.constraint = load_case.num_constraints();
    load_case.conditions.push_back({name_of_touch, core::ConditionKind::touch});
    if (support::optional_flag(touch, "jaws")) {
        tool.between = 0.5 * (tool.start + start_of_other_jaw(touch, load_case, mesh, onto, tool));
        load_case.conditions.push_back({name_of_other_jaw, core::ConditionKind::touch});
    }
    load_case.touching = tool;
}

FirstTouch first_touch_of_ball(const core::TetraMesh &mesh, const Vector3 &onto, const Vector3 &direction,
                               double radius) {
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

/// A point that is beside the flat by s < r is touched where the flat is sqrt(r^2 - s^2) before it.
FirstTouch first_touch_of_plate(const core::TetraMesh &mesh, const Vector3 &onto, const Vector3 &direction,
                                const core::ToolShape &plate) {
    FirstTouch touch{onto, -1};
    double least = std::numeric_limits<double>::infinity();
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const auto corners = core::corners_of(mesh, f);
        const auto look_at = [&](const Vector3 &point) {
            const double height = direction.dot(point - onto);
            // Far behind the face, a point beside it has the gap s - r to the flank.
            const Vector3 beside = point - onto - (height + plate.reach()) * direction;
            const double flank = core::gap_to(plate, beside).size;
            const double s = flank < -plate.radius ? 0.0 : flank + plate.radius;
            const double place = height - std::sqrt(std::max(0.0, plate.radius * plate.radius - s * s));
            if (s < plate.radius && place < least) {
                least = place;
                touch.facet = f;
            }
        };
        const double side = std::max(
            {(corners[0] - corners[1]).norm(), (corners[1] - corners[2]).norm(), (corners[2] - corners[0]).norm()});
        std::ranges::for_each(corners, look_at);
        if ((corners[0] - onto).cross(direction).norm() > plate.reach() + side)
            continue;
        const int parts = std::clamp(static_cast<int>(std::ceil(side / plate.radius)), 1, most_parts);
        for (const auto &[shape, part] : core::facet_points(parts))
            look_at(shape[0] * corners[0] + shape[1] * corners[1] + shape[2] * corners[2]);
    }
    touch.centre += (std::isfinite(least) ? least : 0.0) * direction;
    return touch;
}

/// Either shape has all of its keys.
void look_for_missing_shape(const toml::table &load_case, std::vector<std::string> &missing) {
    const auto &touch = *load_case["touch"].as_table();
    const auto *const key = touch.contains("plate") ? "size" : "radius";
    if (!touch.contains(key))
        missing.push_back(fmt::format("'{}' in the [touch]", key));
}

} // namespace

core::ToolShape tool_shape(const toml::table &tool, const Vector3 &press) {
    const bool is_plate = tool.contains("plate");
    for (const auto *key : {"radius", "size", "edge_radius"})
        if (const auto *found = tool.get(key); found && (key == std::string_view("radius")) == is_plate)
            throw support::InputError(fmt::format("{}: '{}' is not of a {}; a ball has a 'radius', and a plate = "
                                                  "\"round\" or \"square\" has a 'size' and an 'edge_radius'",
                                                  support::place_of(*found), key, is_plate ? "plate" : "ball"));
    if (!is_plate)
        return number_of_touch(tool, "radius", false);
    const auto name = support::required_string(tool, "plate");
    const bool is_round = name == "round";
    if (!is_round && name != "square")
        throw support::InputError(fmt::format("{}: the plate is '{}'; write \"round\" or \"square\"",
                                              support::place_of(*tool.get("plate")), name));
    const double size = number_of_touch(tool, "size", false);
    return {is_round ? core::ToolFace::round : core::ToolFace::square, size,
            tool.contains("edge_radius") ? number_of_touch(tool, "edge_radius", false) : usual_edge_radius * size,
            press};
}

FirstTouch first_touch(const core::TetraMesh &mesh, const Vector3 &onto, const Vector3 &direction,
                       const core::ToolShape &shape) {
    return shape.is_plate() ? first_touch_of_plate(mesh, onto, direction, shape)
                            : first_touch_of_ball(mesh, onto, direction, shape.radius);
}

namespace events {

/// A rigid ball or plate that touches.
EventReader touch() {
    return {.name = {},
            .what = "has a ball that touches",
            .folder = "load_cases/touching",
            .quantities = {.lengths = {"radius", "size", "edge_radius", "depth", "slide"},
                           .directions = {"slide"},
                           .has_place = true},
            .required = {"depth"},
            .look_for_missing = look_for_missing_shape,
            .refuse_company = refuse_company_of_touch,
            .read = read_touch};
}

} // namespace events

} // namespace livermark::load_cases
