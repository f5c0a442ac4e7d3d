#include <algorithm>
#include <fmt/format.h>
#include <numbers>
#include <optional>

#include "core/mesh/tetra_mesh.hpp"
#include "load_cases/places/selector.hpp"

namespace livermark::load_cases::selectors {

namespace {

using core::Vector3;

/// Position of a disc: around which facet, of which it may have.
struct Place {
    std::string name;
    std::vector<int> facets;
    std::optional<SurfacePoint> middle{};
};

Place around_patch(const toml::table &disc, const core::TetraMesh &mesh) {
    const auto name = support::required_string(disc, "patch");
    Place place{"disc on " + name, facets_of_patch(name, *disc.get("patch"), mesh)};
    if (!place.facets.empty())
        place.middle = nearest_point(place.facets, mesh, middle_of(place.facets, mesh));
    return place;
}

Place seen_from(const toml::table &disc, const core::TetraMesh &mesh, double radius) {
    const bool from_region = disc.contains("region");
    const auto region = from_region ? support::required_string(disc, "region") : "";
    const Vector3 origin =
        from_region ? region_centroid(region, *disc.get("region"), mesh) : support::required_vector(disc, "point");
    Place place{from_region ? "disc over " + region
                            : fmt::format("disc at ({:g}, {:g}, {:g}) m", origin.x(), origin.y(), origin.z()),
                all_facets(mesh)};
    const bool has_direction = disc.contains("direction");
    if (const double size = core::extent(mesh.points); !from_region)
        nearest_to_given(disc, "point", mesh, origin,
                         has_direction ? size : std::max(radius, farthest_from_surface * size));
    if (!has_direction) {
        place.middle = nearest_point(place.facets, mesh, origin);
        return place;
    }
    const auto direction = support::required_vector(disc, "direction");
    if (!(direction.norm() > 0.0))
        support::refuse(*disc.get("direction"), "the 'direction' is zero; give one that points somewhere");
    place.middle = exit_point(mesh, origin, direction, Exit::last);
    return place;
}

Place find_place(const toml::table &disc, const core::TetraMesh &mesh, double radius) {
    const int num_origins = int{disc.contains("patch")} + int{disc.contains("point")} + int{disc.contains("region")};
    if (num_origins != 1)
        support::refuse(disc, "a disc lies on a 'patch', or at a 'point' or over a 'region'; give one of them");
    if (!disc.contains("patch"))
        return seen_from(disc, mesh, radius);
    if (disc.contains("direction"))
        support::refuse(
            *disc.get("direction"),
            "a disc on a 'patch' lies in its middle; leave the 'direction' out, or give a 'point' or a 'region'");
    return around_patch(disc, mesh);
}

/// Its facets that face the way of the middle and are inside, one at least; for a load all that reach in.
void keep_disc(Place &place, const core::TetraMesh &mesh, double radius, const core::RoundLoad &tool, bool has_all) {
    std::erase_if(place.facets, [&](int f) {
        if (area_vector(mesh, f).dot(area_vector(mesh, place.middle->facet)) <= 0.0)
            return true;
        return has_all ? core::mean_height(tool, core::corners_of(mesh, f)) == 0.0
                       : f != place.middle->facet && (facet_centroid(mesh, f) - place.middle->point).norm() > radius;
    });
}

core::RoundLoad round_tool(const Place &place, double radius) {
    return {place.middle->point, radius};
}

/// The place where the mean normal of a disc, followed inwards from its middle, leaves the body.
Place opposite(Place place, const core::TetraMesh &mesh, double radius) {
    const auto tool = round_tool(place, radius);
    keep_disc(place, mesh, radius, tool, true);
    if (place.facets.empty())
        return place;
    const Vector3 inwards = -pressed_normal({place.name, place.facets, {}, tool}, mesh);
    return {place.name + ", far side", all_facets(mesh), exit_point(mesh, place.middle->point, inwards, Exit::first)};
}

Selection select(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &) {
    const auto &disc = support::required_table(condition, "disc");
    support::refuse_unknown_keys(disc, {"patch", "point", "region", "direction", "radius", "opposite", "profile"});
    const double radius = support::required_number(disc, "radius");
    if (!(radius > 0.0))
        support::refuse(disc, "the radius is {} m; it has to be positive", radius);
    refuse_beyond_body(disc, "radius", radius, mesh);
    const bool has_round_tool = is_round(disc);
    auto place = find_place(disc, mesh, radius);
    if (place.middle && support::optional_flag(disc, "opposite"))
        place = opposite(place, mesh, radius);
    if (!place.middle)
        return {place.name, {}};
    const auto tool = round_tool(place, radius);
    keep_disc(place, mesh, radius, tool, has_round_tool && !prescribes_displacement(condition));
    return {place.name, place.facets, std::numbers::pi * radius * radius,
            has_round_tool ? std::optional(tool) : std::nullopt};
}

} // namespace

/// disc = { patch = "anterior", radius = 0.01, profile = "round" }: the facets whose centroid is within the radius [m]
/// of a point in the middle, and that face the same way; under the load of a round tool all that reach into it. The
/// middle is
///   of a patch     the point of it that is nearest to its area centroid; the disc has facets of the patch only
///   of a point or region, as in { region = "tumour_1", direction = [0, 0, 1], radius = 0.01 }
///                  where the direction, followed from the point [m] or the centroid of the region, leaves the body for
///                  the last time; without a direction, the point of the surface that is nearest to it
/// A point has to be within a tenth of the size of the body, or the radius, of the surface; with a direction, which may
/// come from outside, within the size of the body.
/// With opposite = true it is the place that faces this one: where the mean normal of its facets, followed inwards from
/// the middle, leaves the body.
Selector disc() {
    return {.name = {}, .select = select};
}

} // namespace livermark::load_cases::selectors
