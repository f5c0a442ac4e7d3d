#include "load_cases/selector.hpp"

#include <fmt/format.h>
#include <utility>

#include "load_cases/facets.hpp"

namespace livermark::load_cases {

namespace {

void refuse_empty(const Selection &selection, const toml::table &place) {
    if (selection.facets.empty())
        throw NotOnBody(support::place_of(place), fmt::format("no facet of the body is in '{}'", selection.name),
                        "choose another place or a larger one");
}

} // namespace

NotOnBody::NotOnBody(const std::string &where, std::string reason, const std::string &remedy)
    : support::InputError(fmt::format("{}: {}; {}", where, reason, remedy)), reason_(std::move(reason)) {}

double area_ratio(const Selection &selection, const core::TetraMesh &mesh) {
    return selection.area ? *selection.area / area_of(selection.facets, mesh) : 1.0;
}

Selection select_facets(const toml::table &condition, const core::TetraMesh &mesh,
                        std::span<const core::FacetCondition> taken) {
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
        throw support::InputError(fmt::format("{}: a condition applies to one of '{}'; give one of them",
                                              support::place_of(condition), fmt::join(known, "', '")));
    auto selection = chosen->select(condition, mesh, taken);
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
