#include "load_cases/places/selector.hpp"

#include <fmt/format.h>
#include <utility>

#include "load_cases/places/facets.hpp"

namespace livermark::load_cases {

namespace {

void refuse_empty(const Selection &selection, const toml::table &place) {
    if (selection.facets.empty())
        throw NotOnBody(support::place_of(place), fmt::format("no facet of the body is in '{}'", selection.name),
                        "choose another place or a larger one");
}

/// Mean pressure of the tool on a facet, over its pressure in the middle.
double pressure_on(const Selection &selection, const core::TetraMesh &mesh, int facet) {
    return selection.tool ? core::mean_height(*selection.tool, core::corners_of(mesh, facet)) : 1.0;
}

} // namespace

NotOnBody::NotOnBody(const std::string &where, std::string reason, const std::string &remedy)
    : support::InputError("{}: {}; {}", where, reason, remedy), reason_(std::move(reason)) {}

std::vector<double> load_shares(const Selection &selection, const core::TetraMesh &mesh) {
    std::vector<double> shares(mesh.boundary_triangles.size(), 0.0);
    double pressed_area = 0.0;
    for (const int f : selection.facets) {
        shares[f] = pressure_on(selection, mesh, f);
        pressed_area += shares[f] * area_vector(mesh, f).norm();
    }
    if (selection.area)
        for (double &share : shares)
            share *= *selection.area / pressed_area;
    return shares;
}

core::Vector3 pressed_normal(const Selection &selection, const core::TetraMesh &mesh) {
    core::Vector3 sum = core::Vector3::Zero();
    for (const int f : selection.facets)
        sum += pressure_on(selection, mesh, f) * area_vector(mesh, f);
    return sum / sum.norm();
}

bool is_round(const toml::table &place) {
    if (!place.contains("profile"))
        return false;
    const auto profile = support::required_string(place, "profile");
    if (profile != "round" && profile != "flat")
        support::refuse(*place.get("profile"), "there is no profile '{}'; a tool is \"round\" or \"flat\"", profile);
    return profile == "round";
}

bool prescribes_displacement(const toml::table &condition) {
    return condition.contains("displacement") || condition.contains("push");
}

Selection select_facets(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &above) {
    const Selector *chosen = nullptr;
    int num_named = 0;
    std::vector<std::string> known;
    for (const auto &selector : all_selectors()) {
        known.push_back(selector.name);
        if (condition.contains(selector.name)) {
            chosen = &selector;
            ++num_named;
        }
    }
    if (num_named != 1)
        support::refuse(condition, "a condition applies to one of '{}'; give one of them", fmt::join(known, "', '"));
    auto selection = chosen->select(condition, mesh, above);
    refuse_empty(selection, condition);
    return selection;
}

int select_node(const toml::table &probe, const core::TetraMesh &mesh) {
    const auto name = support::required_string(probe, "patch");
    const Selection selection{name, facets_of_patch(name, *probe.get("patch"), mesh)};
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
