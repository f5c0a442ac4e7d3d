#include "server/sessions/live_body.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <utility>
#include <vector>

#include "results/hdf5/result_file.hpp"
#include "server/site.hpp"
#include "support/input_error.hpp"

namespace livermark::server {

namespace {

core::LoadCase support_only(const core::LoadCase &load_case) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto num_facets = load_case.condition.size();
    core::LoadCase constrained;
    constrained.name = load_case.name + ", constraints only";
    constrained.title = load_case.title;
    constrained.constraint_names = {"constrained"};
    constrained.condition.assign(num_facets, core::FacetCondition::free);
    constrained.value.assign(num_facets, core::Vector3::Constant(nan));
    constrained.constraint.assign(num_facets, -1);
    for (std::size_t f = 0; f < num_facets; ++f)
        if (load_case.condition[f] == core::FacetCondition::prescribed_displacement &&
            load_case.value[f] == core::Vector3::Zero()) {
            constrained.condition[f] = core::FacetCondition::prescribed_displacement;
            constrained.value[f] = core::Vector3::Zero();
            constrained.constraint[f] = 0;
        }
    return constrained;
}

} // namespace

LiveBody open_live_body(const std::filesystem::path &folder, const Fields &query) {
    const auto &name = required_text(query, "file");
    const auto path = shown_file(name, folder);
    if (!path)
        throw support::InputError(
            fmt::format("{}: there is no such result file here; choose one of the list", support::shown(name)));
    auto [body, load_case] = results::read_result(*path).problem;
    auto constrained = support_only(load_case);
    if (std::ranges::all_of(constrained.constraint, [](int constraint) { return constraint < 0; }))
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
