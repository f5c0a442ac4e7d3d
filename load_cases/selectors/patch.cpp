#include "load_cases/places/selector.hpp"

namespace livermark::load_cases::selectors {

namespace {

Selection select(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &) {
    const auto name = support::required_string(condition, "patch");
    return {name, facets_of_patch(name, *condition.get("patch"), mesh)};
}

} // namespace

/// patch = "anterior": a named part of the boundary.
Selector patch() {
    return {.name = {}, .select = select};
}

} // namespace livermark::load_cases::selectors
