#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/tool/tool_motion.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"

namespace livermark::load_cases {

namespace {

/// A motion of more frames was asked for by a slip of the unit.
constexpr double most_frames = 1e4;
constexpr double usual_frame_rate = 60.0; // [1/s]
/// Part of a frame by which times may miss whole ones.
constexpr double rounding_of_frames = 1e-6;

/// @param otherwise  where the key is left out
double number_or(const toml::table &table, std::string_view key, double otherwise) {
    return table.contains(key) ? support::required_number(table, key) : otherwise;
}

core::ToolMotion read_times(const toml::table &tool) {
    core::ToolMotion motion;
    motion.press_until = support::required_number(tool, "press_until");
    motion.release_at = support::required_number(tool, "release_at");
    motion.slide_from = number_or(tool, "slide_from", motion.press_until);
    motion.slide_until = number_or(tool, "slide_until", motion.release_at);
    const double duration = support::required_number(tool, "duration");
    const bool ascends = 0.0 < motion.press_until && motion.press_until <= motion.slide_from &&
                         motion.slide_from < motion.slide_until && motion.slide_until <= motion.release_at &&
                         motion.release_at <= duration;
    if (!ascends)
        support::refuse(tool, "the times of a tool have to ascend: 0 < press_until <= slide_from < slide_until <= "
                              "release_at <= duration");
    const double frame_rate = number_or(tool, "frame_rate", usual_frame_rate);
    const auto is_whole = [&](double time) {
        return std::abs(time * frame_rate - std::round(time * frame_rate)) < rounding_of_frames;
    };
    if (!(frame_rate > 0.0) || !(duration * frame_rate <= most_frames) || !is_whole(duration) ||
        !is_whole(motion.release_at))
        support::refuse(tool,
                        "'duration' and 'release_at' have to be whole numbers of frames of 1 / 'frame_rate', {} at "
                        "most; change one of them",
                        most_frames);
    motion.frame_interval = 1.0 / frame_rate;
    motion.num_frames = static_cast<int>(std::lround(duration * frame_rate));
    return motion;
}

/// Whether it may touch as well.
bool has_shape(const toml::table &tool) {
    return tool.contains("radius") || tool.contains("plate") || tool.contains("size") || tool.contains("edge_radius");
}

core::ToolMotion tool_of(const toml::table &table, const core::LoadCase &load_case) {
    const auto &tool = support::required_table(table, "tool");
    support::refuse_unknown_keys(tool,
                                 {"place", "press_until", "slide", "slide_from", "slide_until", "release_at",
                                  "duration", "frame_rate", "mass_damping", "radius", "plate", "size", "edge_radius"});
    if (has_shape(tool))
        tool_shape(tool, core::Vector3::UnitZ());
    auto motion = read_times(tool);
    const auto place = support::required_string(tool, "place");
    const auto names = load_case.constraint_names();
    const auto found = std::ranges::find(names, place);
    if (found == names.end())
        support::refuse(*tool.get("place"), "no [[condition]] with a displacement has the name '{}'; known are: {}",
                        place, fmt::join(names, ", "));
    motion.constraint = static_cast<int>(found - names.begin());
    motion.slide = tool.contains("slide") ? support::required_vector(tool, "slide") : core::Vector3(0.0, 0.0, 0.0);
    motion.mass_damping = support::required_number(tool, "mass_damping");
    if (motion.mass_damping < 0.0)
        support::refuse(*tool.get("mass_damping"), "'mass_damping' is {}; it has to be zero or more",
                        motion.mass_damping);
    if (load_case.regime != core::Regime::large || load_case.release || load_case.scale_to_target ||
        !load_case.acceleration.isZero(0.0))
        support::refuse(tool, "a tool moves in the large regime, from rest and without a release, an acceleration or a "
                              "scale; leave those out, or the [tool]");
    for (int f = 0; f < load_case.num_facets(); ++f) {
        const auto &value = load_case.value[f];
        const bool is_tool = load_case.constraint_on(f) == motion.constraint;
        if (load_case.is_loaded(f) || (is_tool && value.array().isNaN().any()) ||
            (load_case.constraint_on(f) >= 0 && !is_tool && !value.isZero(0.0)))
            support::refuse(
                tool, "a moving tool has to be the only load; constrain all other places to zero in all components");
    }
    return motion;
}

void read_tool(const Reading &reading) {
    reading.load_case.tool = tool_of(reading.table, reading.load_case);
}

void refuse_body_that_is_free_of_the_tool(const Reading &reading) {
    refuse_free_body(reading.mesh, core::let_go(reading.load_case), reading.file.string());
}

/// The middle of what is pushed, and how far that is at most.
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
        throw support::InputError("load case {}: the place of the tool is not pushed, so no ball can press there; give "
                                  "it a 'push' or another displacement",
                                  load_case.name);
    place.middle /= weight;
    return place;
}

} // namespace

core::LoadCase with_touching_ball(core::LoadCase load_case, const core::TetraMesh &mesh, double friction) {
    auto table = support::parse_toml(load_case.definition, load_case.name + ".toml");
    bring_to_metres(table);
    const auto &tool = support::required_table(table, "tool");
    if (!has_shape(tool))
        throw support::InputError("load case {}: the [tool] has no radius, so it is not a ball that can touch; give it "
                                  "a 'radius' [m] or a 'plate', or take --tool glued",
                                  load_case.name);
    const auto place = pushed_place(load_case, mesh);
    const auto shape = tool_shape(tool, place.press);
    const core::TouchingTool ball{.shape = shape,
                                  .start = first_touch(mesh, place.middle, place.press.normalized(), shape).centre,
                                  .press = place.press,
                                  .friction = friction,
                                  .constraint = load_case.tool->constraint};
    auto touched = core::let_go(std::move(load_case));
    touched.node_factor.clear();
    touched.touching = ball;
    return touched;
}

namespace events {

/// A tool that presses, slides and lets go.
EventReader tool() {
    return {.name = {},
            .what = "has a tool that moves",
            .command = "arena",
            .folder = "load_cases/moving",
            .in_time = true,
            .quantities = {.lengths = {"radius", "size", "edge_radius", "slide"}, .directions = {"slide"}},
            .required = {"place", "press_until", "release_at", "duration", "mass_damping"},
            .read = read_tool,
            .check = refuse_body_that_is_free_of_the_tool};
}

} // namespace events

} // namespace livermark::load_cases
