
#include "load_cases/places/selector.hpp"

namespace livermark::load_cases::selectors {

namespace {

Selection select(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &above) {
    if (!support::optional_flag(condition, "rest"))
        support::refuse(*condition.get("rest"), "'rest' can only be true; or name another place");
    Selection selection{"the rest of the surface", all_facets(mesh)};
    std::erase_if(selection.facets, [&](int f) { return !above.is_free(f); });
    return selection;
}

} // namespace

/// rest = true: all that the conditions above leave free. A condition below it finds no facet left.
Selector rest() {
    return {.name = {}, .select = select};
}

} // namespace livermark::load_cases::selectors
