#include "load_cases/places/facets.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>

#include "core/mesh/bounding_box.hpp"
#include "core/mesh/patches.hpp"
#include "core/mesh/triangle.hpp"
#include "core/units.hpp"
#include "load_cases/places/selector.hpp"
#include "support/length_unit.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

/// Barycentric coordinates may be this far below zero: a ray through an edge goes through one facet at least.
constexpr double rounding_of_facets = 1e-9;

/// How far along a ray [lengths of the direction] it goes through a facet from inside; nothing if it does not.
/// (Moeller and Trumbore 1997)
std::optional<double> crossing(const core::TetraMesh &mesh, int facet, const Vector3 &origin,
                               const Vector3 &direction) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    const Vector3 ab = mesh.points[b] - mesh.points[a];
    const Vector3 ac = mesh.points[c] - mesh.points[a];
    const double volume = ab.cross(ac).dot(direction);
    if (!(volume > 0.0))
        return std::nullopt;
    const Vector3 from_a = origin - mesh.points[a];
    const Vector3 side = from_a.cross(direction);
    const double v = -ac.dot(side) / volume;
    const double w = ab.dot(side) / volume;
    const double along = -from_a.dot(ab.cross(ac)) / volume;
    if (v < -rounding_of_facets || w < -rounding_of_facets || v + w > 1.0 + rounding_of_facets || along < 0.0)
        return std::nullopt;
    return along;
}

Vector3 nearest_of_facet(const core::TetraMesh &mesh, int facet, const Vector3 &point) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return core::nearest_of_triangle({mesh.points[a], mesh.points[b], mesh.points[c]}, point);
}

} // namespace

std::vector<int> all_facets(const core::TetraMesh &mesh) {
    std::vector<int> facets(mesh.boundary_triangles.size());
    std::iota(facets.begin(), facets.end(), 0);
    return facets;
}

std::vector<int> facets_of_patch(const std::string &name, const toml::node &place, const core::TetraMesh &mesh) {
    const auto known = core::patches_of(mesh);
    if (std::ranges::find(known, name) == known.end())
        throw NotOnBody(support::place_of(place), fmt::format("the body has no patch '{}'", name),
                        fmt::format("it has {}; find_patches = true in the .toml of a liver finds those of livers",
                                    fmt::join(known, ", ")));
    return core::facets_in_patch(mesh, name);
}

Vector3 facet_centroid(const core::TetraMesh &mesh, int facet) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0;
}

double area_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    double area = 0.0;
    for (const int f : facets)
        area += area_vector(mesh, f).norm();
    return area;
}

Vector3 middle_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    Vector3 moment = Vector3::Zero();
    double area = 0.0;
    for (const int f : facets) {
        const double facet_area = area_vector(mesh, f).norm();
        moment += facet_area * facet_centroid(mesh, f);
        area += facet_area;
    }
    return moment / area;
}

SurfacePoint nearest_point(const std::vector<int> &facets, const core::TetraMesh &mesh, const Vector3 &point) {
    SurfacePoint nearest{facets.front(), nearest_of_facet(mesh, facets.front(), point)};
    for (const int f : facets)
        if (const Vector3 candidate = nearest_of_facet(mesh, f, point);
            (candidate - point).squaredNorm() < (nearest.point - point).squaredNorm())
            nearest = {f, candidate};
    return nearest;
}

SurfacePoint nearest_to_given(const toml::table &table, std::string_view key, const core::TetraMesh &mesh,
                              const Vector3 &point, double farthest) {
    const auto facets = all_facets(mesh);
    const auto from_surface = [&](const Vector3 &other) {
        return (nearest_point(facets, mesh, other).point - other).norm();
    };
    auto nearest = nearest_point(facets, mesh, point);
    const double away = (nearest.point - point).norm();
    if (away <= farthest)
        return nearest;
    std::string remedy = "give a point that is near the surface, in metres or in the 'unit' of the load case";
    // Whatever is divided by a thousand is near the origin, and that may be near the surface.
    const bool is_elsewhere = away > core::extent(mesh.points);
    for (const auto &[name, metres] : support::length_units) {
        if (metres == 1.0)
            continue;
        if (is_elsewhere && from_surface(metres * point) <= farthest) {
            remedy = fmt::format("give it in metres; or write unit = \"{0}\" in the load case, and all of its lengths "
                                 "in {0}",
                                 name);
            break;
        }
        if (from_surface(point / metres) <= farthest)
            remedy = fmt::format(
                "multiplied by {:g} it is near the surface: correct it, or the 'unit' of the load case", 1.0 / metres);
    }
    const auto shown = [](const Vector3 &p) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z()); };
    throw NotOnBody(support::place_of(*table.get(key)),
                    fmt::format("the '{}' {} m is {:.3g} m from the surface of the body, whose nearest point is {} m, "
                                "which is {} mm",
                                key, shown(point), away, shown(nearest.point),
                                shown(core::millimetres * nearest.point)),
                    remedy);
}

void refuse_beyond_body(const toml::table &table, std::string_view key, double length, const core::TetraMesh &mesh) {
    if (const double size = core::extent(mesh.points); length > size)
        throw NotOnBody(support::place_of(*table.get(key)),
                        fmt::format("the '{}' is {:.4g} m, and the body is {:.3g} m across", key, length, size),
                        "give it in metres; or write unit = \"mm\" in the load case, and all of its lengths in mm");
}

std::optional<SurfacePoint> exit_point(const core::TetraMesh &mesh, const Vector3 &origin, const Vector3 &direction,
                                       Exit which) {
    std::optional<SurfacePoint> chosen;
    double at = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (const auto along = crossing(mesh, f, origin, direction);
            along && (!chosen || (which == Exit::first ? *along < at : *along > at))) {
            chosen = SurfacePoint{f, origin + *along * direction};
            at = *along;
        }
    return chosen;
}

core::Vector3 region_centroid(const std::string &name, const toml::node &place, const core::TetraMesh &mesh) {
    const auto region = std::ranges::find(mesh.region_names, name) - mesh.region_names.begin();
    if (region == std::ssize(mesh.region_names))
        throw NotOnBody(support::place_of(place), fmt::format("the body has no region '{}'", name),
                        fmt::format("it has {}", fmt::join(mesh.region_names, ", ")));
    const auto volumes = tetrahedron_volumes(mesh);
    core::Vector3 moment = core::Vector3::Zero();
    double volume = 0.0;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        if (mesh.region[t] == region) {
            for (const int node : mesh.tetrahedra[t])
                moment += 0.25 * volumes[t] * mesh.points[node];
            volume += volumes[t];
        }
    return moment / volume;
}

} // namespace livermark::load_cases
