#include "load_cases/facets.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>

#include "load_cases/selector.hpp"

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

} // namespace

std::vector<int> all_facets(const core::TetraMesh &mesh) {
    std::vector<int> facets(mesh.boundary_triangles.size());
    std::iota(facets.begin(), facets.end(), 0);
    return facets;
}

std::vector<int> facets_of_patch(const std::string &name, const toml::node &place, const core::TetraMesh &mesh) {
    const auto found = std::ranges::find(mesh.patch_names, name);
    if (found == mesh.patch_names.end())
        throw NotOnBody(support::place_of(place), fmt::format("the body has no patch '{}'", name),
                        fmt::format("it has {}", fmt::join(mesh.patch_names, ", ")));
    auto facets = all_facets(mesh);
    std::erase_if(facets, [&](int f) { return mesh.boundary_patch[f] != found - mesh.patch_names.begin(); });
    return facets;
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

Vector3 mean_normal(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    Vector3 sum = Vector3::Zero();
    for (const int f : facets)
        sum += area_vector(mesh, f);
    return sum / sum.norm();
}

int nearest_facet(const std::vector<int> &facets, const core::TetraMesh &mesh, const Vector3 &point) {
    return *std::ranges::min_element(facets, {},
                                     [&](int f) { return (facet_centroid(mesh, f) - point).squaredNorm(); });
}

std::optional<int> exit_facet(const core::TetraMesh &mesh, const Vector3 &origin, const Vector3 &direction,
                              Exit which) {
    std::optional<int> chosen;
    double at = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (const auto along = crossing(mesh, f, origin, direction);
            along && (!chosen || (which == Exit::first ? *along < at : *along > at))) {
            chosen = f;
            at = *along;
        }
    return chosen;
}

} // namespace livermark::load_cases
