#include <algorithm>
#include <fmt/format.h>

#include "load_cases/places/selector.hpp"

namespace livermark::load_cases::selectors {

namespace {

Selection select(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &) {
    Selection selection;
    const auto names = support::required_strings(condition, "patches");
    selection.name = fmt::format("{}", fmt::join(names, " and "));
    for (const auto &name : names) {
        const auto facets = facets_of_patch(name, *condition.get("patches"), mesh);
        selection.facets.insert(selection.facets.end(), facets.begin(), facets.end());
    }
    std::ranges::sort(selection.facets);
    selection.facets.erase(std::unique(selection.facets.begin(), selection.facets.end()), selection.facets.end());
    return selection;
}

} // namespace

/// patches = ["anterior", "superior"]: several patches as one place, with one reaction.
Selector patches() {
    return {.name = {}, .select = select};
}

} // namespace livermark::load_cases::selectors
