#include "load_cases/selectors.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <numbers>

#include "core/input_error.hpp"

namespace livermark::load_cases {

namespace {

std::vector<int> facets_of_patch(const toml::table &table, const core::TetraMesh &mesh) {
    const auto name = core::required_string(table, "patch");
    const auto found = std::ranges::find(mesh.patch_names, name);
    if (found == mesh.patch_names.end())
        throw core::InputError(fmt::format("{}: the body has no patch '{}'; it has {}",
                                           core::place_of(*table.get("patch")), name,
                                           fmt::join(mesh.patch_names, ", ")));
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == found - mesh.patch_names.begin())
            facets.push_back(f);
    return facets;
}

core::Vector3 centroid(const core::TetraMesh &mesh, int facet) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0;
}

/// Area centroid of facets.
core::Vector3 middle_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    core::Vector3 moment = core::Vector3::Zero();
    double area = 0.0;
    for (const int f : facets) {
        const double facet_area = area_vector(mesh, f).norm();
        moment += facet_area * centroid(mesh, f);
        area += facet_area;
    }
    return moment / area;
}

/// The facet in the middle: its centroid is nearest to the area centroid of all.
int middle_facet(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    const core::Vector3 middle = middle_of(facets, mesh);
    return *std::ranges::min_element(facets, {}, [&](int f) { return (centroid(mesh, f) - middle).squaredNorm(); });
}

double area_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    double area = 0.0;
    for (const int f : facets)
        area += area_vector(mesh, f).norm();
    return area;
}

std::vector<int> facets_of_disc(const toml::table &disc, const core::TetraMesh &mesh) {
    core::refuse_unknown_keys(disc, {"patch", "radius"});
    auto facets = facets_of_patch(disc, mesh);
    const double radius = core::required_number(disc, "radius");
    if (!(radius > 0.0))
        throw core::InputError(
            fmt::format("{}: the radius is {} m; it has to be positive", core::place_of(disc), radius));
    if (facets.empty())
        return facets;
    const int middle = middle_facet(facets, mesh);
    std::erase_if(facets, [&](int f) {
        return (centroid(mesh, f) - centroid(mesh, middle)).norm() > radius ||
               area_vector(mesh, f).dot(area_vector(mesh, middle)) <= 0.0;
    });
    return facets;
}

void refuse_empty(const Selection &selection, const toml::table &place) {
    if (selection.facets.empty())
        throw core::InputError(fmt::format("{}: no facet of the body is in '{}'; choose another place or a larger one",
                                           core::place_of(place), selection.name));
}

} // namespace

Selection select_facets(const toml::table &condition, const core::TetraMesh &mesh) {
    if (condition.contains("patch") == condition.contains("disc"))
        throw core::InputError(fmt::format("{}: a condition applies to either a 'patch' or a 'disc'; give one of them",
                                           core::place_of(condition)));
    Selection selection;
    if (condition.contains("patch")) {
        selection.name = core::required_string(condition, "patch");
        selection.facets = facets_of_patch(condition, mesh);
    } else {
        const auto &disc = core::required_table(condition, "disc");
        selection.facets = facets_of_disc(disc, mesh);
        selection.name = fmt::format("disc on {}", core::required_string(disc, "patch"));
        const double radius = core::required_number(disc, "radius");
        selection.area_ratio = std::numbers::pi * radius * radius / area_of(selection.facets, mesh);
    }
    refuse_empty(selection, condition);
    return selection;
}

int select_node(const toml::table &probe, const core::TetraMesh &mesh) {
    const Selection selection{core::required_string(probe, "patch"), facets_of_patch(probe, mesh)};
    refuse_empty(selection, probe);
    const core::Vector3 middle = middle_of(selection.facets, mesh);
    int nearest = mesh.boundary_triangles[selection.facets.front()].front();
    for (const int f : selection.facets)
        for (const int node : mesh.boundary_triangles[f])
            if ((mesh.points[node] - middle).squaredNorm() < (mesh.points[nearest] - middle).squaredNorm())
                nearest = node;
    return nearest;
}

} // namespace livermark::load_cases
