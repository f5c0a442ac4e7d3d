#include "load_cases/readers/tool_reader.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "support/input_error.hpp"

namespace livermark::load_cases {

namespace {

/// A motion of more frames was asked for by a slip of the unit.
constexpr double most_frames = 1e4;
constexpr double usual_frame_rate = 60.0; // [1/s]
/// Of a frame, by which times may miss whole ones.
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
        throw support::InputError(fmt::format("{}: the times of a tool have to ascend: 0 < press_until <= slide_from < "
                                              "slide_until <= release_at <= duration",
                                              support::place_of(tool)));
    const double frame_rate = number_or(tool, "frame_rate", usual_frame_rate);
    const auto is_whole = [&](double time) {
        return std::abs(time * frame_rate - std::round(time * frame_rate)) < rounding_of_frames;
    };
    if (!(frame_rate > 0.0) || !(duration * frame_rate <= most_frames) || !is_whole(duration) ||
        !is_whole(motion.release_at))
        throw support::InputError(fmt::format("{}: 'duration' and 'release_at' have to be whole numbers of frames of "
                                              "1 / 'frame_rate', {} at most; change one of them",
                                              support::place_of(tool), most_frames));
    motion.frame_interval = 1.0 / frame_rate;
    motion.num_frames = static_cast<int>(std::lround(duration * frame_rate));
    return motion;
}

} // namespace

core::ToolMotion read_tool(const toml::table &table, const core::LoadCase &load_case) {
    const auto &tool = support::required_table(table, "tool");
    support::refuse_unknown_keys(tool, {"place", "press_until", "slide", "slide_from", "slide_until", "release_at",
                                        "duration", "frame_rate", "mass_damping", "radius"});
    if (tool.contains("radius") && !(support::required_number(tool, "radius") > 0.0))
        throw support::InputError(fmt::format("{}: the 'radius' of the ball that touches has to be positive",
                                              support::place_of(*tool.get("radius"))));
    auto motion = read_times(tool);
    const auto place = support::required_string(tool, "place");
    const auto names = load_case.constraint_names();
    const auto found = std::ranges::find(names, place);
    if (found == names.end())
        throw support::InputError(
            fmt::format("{}: no [[condition]] with a displacement has the name '{}'; known are: {}",
                        support::place_of(*tool.get("place")), place, fmt::join(names, ", ")));
    motion.constraint = static_cast<int>(found - names.begin());
    motion.slide = tool.contains("slide") ? support::required_vector(tool, "slide") : core::Vector3(0.0, 0.0, 0.0);
    motion.mass_damping = support::required_number(tool, "mass_damping");
    if (motion.mass_damping < 0.0)
        throw support::InputError(fmt::format("{}: 'mass_damping' is {}; it has to be zero or more",
                                              support::place_of(*tool.get("mass_damping")), motion.mass_damping));
    if (load_case.regime != core::Regime::large || load_case.release || load_case.scale_to_target ||
        !load_case.acceleration.isZero(0.0))
        throw support::InputError(fmt::format("{}: a tool moves in the large regime, from rest and without a release, "
                                              "an acceleration or a scale; leave those out, or the [tool]",
                                              support::place_of(tool)));
    for (int f = 0; f < load_case.num_facets(); ++f) {
        const auto &value = load_case.value[f];
        const bool is_tool = load_case.constraint_on(f) == motion.constraint;
        if (load_case.is_loaded(f) || (is_tool && value.array().isNaN().any()) ||
            (load_case.constraint_on(f) >= 0 && !is_tool && !value.isZero(0.0)))
            throw support::InputError(fmt::format(
                "{}: a moving tool has to be the only load; constrain all other places to zero in all components",
                support::place_of(tool)));
    }
    return motion;
}

} // namespace livermark::load_cases
