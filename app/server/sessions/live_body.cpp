#include "app/server/sessions/live_body.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <utility>
#include <vector>

#include "app/server/site.hpp"
#include "core/support/input_error.hpp"
#include "results/hdf5/result_file.hpp"

namespace livermark::server {

namespace {

core::LoadCase support_only(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    std::vector<int> held, free_facet; // -1 of those that are held
    for (int f = 0; f < load_case.num_facets(); ++f) {
        const bool is_held = load_case.is_constrained(f) && load_case.value[f] == core::Vector3::Zero();
        if (is_held)
            held.push_back(f);
        free_facet.push_back(is_held ? -1 : f);
    }
    auto constrained = core::with_free_surface({}, mesh);
    constrained.name = load_case.name + ", constraints only";
    constrained.title = load_case.title;
    constrained.put({"constrained"}, held, core::Vector3::Zero());
    constrained.foundation = foundation_on(load_case.foundation, free_facet);
    return constrained;
}

} // namespace

std::optional<core::Foundation> foundation_on(std::optional<core::Foundation> foundation,
                                              const std::vector<int> &facets) {
    if (!foundation)
        return foundation;
    foundation->move_to_parts(facets);
    return foundation->facets.empty() ? std::nullopt : foundation;
}

LiveBody open_live_body(const std::filesystem::path &folder, const Fields &query) {
    const auto &name = required_text(query, "file");
    const auto path = shown_file(name, folder);
    if (!path)
        throw support::InputError(
            fmt::format("{}: there is no such result file here; choose one of the list", support::shown(name)));
    auto [body, load_case] = results::read_result(*path).problem;
    auto constrained = support_only(load_case, body->mesh);
    if (std::ranges::all_of(constrained.condition_on, [](int condition) { return condition < 0; }))
        throw support::InputError(
            fmt::format("{}: its load case {} does not fix any part of the surface, and the body "
                        "would fly away; choose a result of a load case that does, such as palpation",
                        support::shown(name), load_case.name));
    return {.file = support::shown(name), .body = std::move(body), .constrained = std::move(constrained)};
}

LiveMaterial live_material(const Fields &message) {
    return {.young_modulus = required_number(message, "young_modulus", 1.0, 1e9),
            .poisson_ratio = required_number(message, "poisson_ratio", 0.0, 0.49)};
}

} // namespace livermark::server
