#include "load_cases/readers/load_case_reader.hpp"

#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <string_view>

#include "core/mesh/places.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "core/tool/needle/needle.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

constexpr double default_step = 0.0005, usual_spread = 0.006; // [m]
/// A step of a micrometre was asked for by a slip of the unit.
constexpr double most_steps_in = 1e4;
/// Largest distance of a point that is given as one of the surface, over the depth of the needle.
constexpr double farthest_entry = 0.2;
/// Distance between two ways that are one, over their length.
constexpr double same_way = 1e-6;

double number_within(const toml::table &needle, std::string_view key, double low, double high) {
    const double value = support::required_number(needle, key);
    if (!(value >= low && value <= high))
        support::refuse(*needle.get(key), "'{}' is {:g}; it has to be from {:g} to {:g} in SI units", key, value, low,
                        high);
    return value;
}

struct Way {
    SurfacePoint entry;
    Vector3 target;
};

/// Way of a needle below the middle of a patch.
Way way_below(const toml::table &needle, const core::TetraMesh &mesh) {
    const auto patch = support::required_string(needle, "entry");
    const auto facets = facets_of_patch(patch, *needle.get("entry"), mesh);
    if (facets.empty())
        throw NotOnBody(support::place_of(needle), fmt::format("no facet of the body is in '{}'", patch),
                        "choose another patch");
    const auto entry = nearest_point(facets, mesh, middle_of(facets, mesh));
    const double depth = number_within(needle, "depth", 1e-4, 1.0);
    return {entry, entry.point - depth * area_vector(mesh, entry.facet).normalized()};
}

Way way_to_target(const toml::table &needle, const core::TetraMesh &mesh) {
    const auto *node = needle.get("target");
    const Vector3 target = node && node->is_string()
                               ? region_centroid(support::required_string(needle, "target"), *node, mesh)
                               : support::required_vector(needle, "target");
    if (!core::locate(mesh, target).is_inside()) // what is not far outside is refused with the way
        nearest_to_given(needle, "target", mesh, target, farthest_from_surface * core::extent(mesh.points));
    const auto *entry = needle.get("entry");
    if (entry && entry->is_string()) {
        const auto facets = facets_of_patch(support::required_string(needle, "entry"), *entry, mesh);
        if (facets.empty())
            throw NotOnBody(support::place_of(*entry), "no facet of the body is in the patch of the 'entry'",
                            "choose another patch");
        return {nearest_point(facets, mesh, target), target};
    }
    const auto wanted = support::required_vector(needle, "entry");
    const double depth = (target - nearest_point(all_facets(mesh), mesh, wanted).point).norm();
    return {nearest_to_given(needle, "entry", mesh, wanted, farthest_entry * depth), target};
}

Way read_way(const toml::table &needle, const core::TetraMesh &mesh) {
    if (needle.contains("target") == needle.contains("depth"))
        support::refuse(needle, "a needle goes to a 'target' or to a 'depth'; give one of them");
    return needle.contains("target") ? way_to_target(needle, mesh) : way_below(needle, mesh);
}

/// @throws support::InputError unless all of the way but its beginning is inside
void refuse_outside(const Way &way, const core::TetraMesh &mesh, const std::string &place) {
    const double depth = (way.target - way.entry.point).norm();
    const auto exit = exit_point(mesh, way.target, way.entry.point - way.target, Exit::first);
    if (!core::locate(mesh, way.target).is_inside() || !exit ||
        (exit->point - way.entry.point).norm() > same_way * depth)
        throw support::InputError("{}: the straight way from the entry at ({:.4g}, {:.4g}, {:.4g}) m to the target at "
                                  "({:.4g}, {:.4g}, {:.4g}) m leaves the body; choose another entry or target",
                                  place, way.entry.point.x(), way.entry.point.y(), way.entry.point.z(), way.target.x(),
                                  way.target.y(), way.target.z());
}

/// @throws support::InputError if a place on the way touches what is held
void refuse_held(const core::Needle &needle, const Way &way, const core::TetraMesh &mesh,
                 const core::LoadCase &load_case, const std::string &place) {
    const auto is_held = [&](int facet) { return load_case.is_constrained(facet); };
    if (is_held(way.entry.facet))
        throw support::InputError("{}: the entry of '{}' is where '{}' constrains the body; choose another entry",
                                  place, needle.name, load_case.on(way.entry.facet)->place);
    auto facets = all_facets(mesh);
    std::erase_if(facets, [&](int facet) { return !is_held(facet); });
    if (!facets.empty() && (nearest_point(facets, mesh, needle.target).point - needle.target).norm() < needle.spread)
        throw support::InputError(
            "{}: the target of '{}' is within its 'spread' of a constrained place; choose another target", place,
            needle.name);
}

/// @throws support::InputError for forces over places that are smaller than the needle, or that the quadrature of a
///   place does not see in the tetrahedra there
void refuse_small_spread(const core::Needle &needle, const core::TetraMesh &mesh, const toml::node &place) {
    if (needle.spread < 0.5 * needle.diameter)
        support::refuse(place,
                        "a 'spread' of {:g} m is less than the radius of the needle, {:g} m; spread its forces over "
                        "some millimetres, such as {:g} m",
                        needle.spread, 0.5 * needle.diameter, usual_spread);
    if (const double least = core::smallest_spread(needle, mesh); needle.spread < least)
        support::refuse(
            place,
            "a 'spread' of {:g} m is too small for the tetrahedra along '{}'; take {:.3g} m or more, or a finer mesh",
            needle.spread, needle.name, 1e-5 * std::ceil(1e5 * least));
}

core::Needle read_needle(const toml::table &table, const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    support::refuse_unknown_keys(table, {"name", "entry", "target", "depth", "diameter", "spread", "toughness",
                                         "friction", "puncture_force", "side_stiffness", "step"});
    const auto place = support::place_of(table);
    core::Needle needle;
    needle.name = support::required_string(table, "name");
    const auto way = read_way(table, mesh);
    needle.entry = way.entry.point;
    needle.target = way.target;
    needle.diameter = number_within(table, "diameter", 1e-5, 0.02);
    needle.spread = number_within(table, "spread", 1e-4, 0.1);
    needle.toughness = number_within(table, "toughness", 0.0, 1e5);
    needle.friction = number_within(table, "friction", 0.0, 1e4);
    needle.puncture_force = table.contains("puncture_force")
                                ? number_within(table, "puncture_force", needle.tip_force(), 100.0)
                                : needle.tip_force();
    if (table.contains("side_stiffness"))
        needle.side_stiffness = number_within(table, "side_stiffness", 1.0, 1e12);
    needle.step = table.contains("step") ? number_within(table, "step", 1e-6, 0.1) : default_step;
    if (!(needle.tip_force() > 0.0))
        support::refuse(*table.get("toughness"),
                        "'toughness' has to be positive; give the energy over area that tears the tissue [J/m^2]");
    if (!(needle.depth() > needle.spread))
        throw support::InputError("{}: the target of '{}' is {:.3g} m below its entry, less than its 'spread' of "
                                  "{:.3g} m; choose a deeper target or spread the forces less",
                                  place, needle.name, needle.depth(), needle.spread);
    if (needle.depth() > most_steps_in * needle.step)
        throw support::InputError("{}: a 'step' of {:g} m would make more than {:g} steps; choose a longer one", place,
                                  needle.step, most_steps_in);
    refuse_outside(way, mesh, place);
    refuse_small_spread(needle, mesh, *table.get("spread"));
    refuse_held(needle, way, mesh, load_case, place);
    return needle;
}

void refuse_same(const std::vector<core::Needle> &needles, const core::Needle &needle, const std::string &place) {
    for (const auto &other : needles) {
        if (other.name == needle.name)
            throw support::InputError("{}: two needles have the name '{}'; rename one", place, needle.name);
        if ((other.entry - needle.entry).norm() + (other.target - needle.target).norm() < same_way * needle.depth())
            throw support::InputError("{}: '{}' and '{}' take the same path; leave one out", place, other.name,
                                      needle.name);
    }
}

} // namespace

std::vector<core::Needle> read_needles(const std::filesystem::path &toml_file, const core::Body &body,
                                       const core::LoadCase &load_case) {
    auto table = support::parse_toml(support::read_text(toml_file), toml_file);
    bring_to_metres(table);
    const auto *array = table.get("needle");
    if (!array || !array->is_array_of_tables())
        throw support::InputError("{}: there is no [[needle]]; add one, or give this load case to 'livermark run'",
                                  toml_file.string());
    if (load_case.regime == core::Regime::large || load_case.release || load_case.tool || core::is_driven(load_case))
        throw support::InputError("{}: beside a needle conditions may only constrain the body, in the small regime; "
                                  "leave loads, displacements other than 0, 'release' and 'tool' out",
                                  toml_file.string());
    std::vector<core::Needle> needles;
    for (const auto &node : *array->as_array()) {
        const auto &one = *node.as_table();
        auto needle = read_needle(one, body.mesh, load_case);
        refuse_same(needles, needle, support::place_of(one));
        needles.push_back(std::move(needle));
    }
    return needles;
}

namespace events {

/// Needles that are driven in and drawn out.
EventReader needle() {
    return {.name = {},
            .what = "has a needle",
            .command = "needle",
            .folder = "load_cases/needles",
            .quantities = {.lengths = {"entry", "target", "depth", "diameter", "spread", "step"}}};
}

} // namespace events

} // namespace livermark::load_cases
