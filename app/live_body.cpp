#include "app/live_body.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <utility>
#include <vector>

#include "core/input_error.hpp"
#include "results/result_file.hpp"
#include "server/site.hpp"

namespace livermark::app {

namespace {

core::LoadCase hold_still(const core::LoadCase &load_case) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto num_facets = load_case.condition.size();
    core::LoadCase held;
    held.name = load_case.name + ", held only";
    held.title = load_case.title;
    held.constraint_names = {"held"};
    held.condition.assign(num_facets, core::FacetCondition::free);
    held.value.assign(num_facets, core::Vector3::Constant(nan));
    held.constraint.assign(num_facets, -1);
    for (std::size_t f = 0; f < num_facets; ++f)
        if (load_case.condition[f] == core::FacetCondition::prescribed_displacement &&
            load_case.value[f] == core::Vector3::Zero()) {
            held.condition[f] = core::FacetCondition::prescribed_displacement;
            held.value[f] = core::Vector3::Zero();
            held.constraint[f] = 0;
        }
    return held;
}

} // namespace

LiveBody open_live_body(const std::filesystem::path &folder, const server::Fields &query) {
    const auto &name = server::required_text(query, "file");
    const auto path = server::shown_file(name, folder);
    if (!path)
        throw core::InputError(
            fmt::format("{}: there is no such result file here; choose one of the list", core::shown(name)));
    auto [body, load_case] = results::read_result(*path).problem;
    auto held = hold_still(load_case);
    if (std::ranges::all_of(held.constraint, [](int constraint) { return constraint < 0; }))
        throw core::InputError(
            fmt::format("{}: its load case {} does not hold the surface still anywhere, and the body "
                        "would fly away; choose a result in which it does, such as one of palpation",
                        core::shown(name), load_case.name));
    return {.file = core::shown(name), .body = std::move(body), .held = std::move(held)};
}

LiveMaterial live_material(const server::Fields &message) {
    return {.young_modulus = server::required_number(message, "young_modulus", 1.0, 1e9),
            .poisson_ratio = server::required_number(message, "poisson_ratio", 0.0, 0.49)};
}

} // namespace livermark::app
