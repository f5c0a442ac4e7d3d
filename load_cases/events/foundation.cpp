#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "core/events.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"

namespace livermark::load_cases {

namespace {

void refuse_company_of_foundation(const Reading &reading) {
    const auto &foundation = support::required_table(reading.table, "foundation");
    support::refuse_unknown_keys(foundation, keys_with_place({"stiffness", "normal_only"}));
    if (reading.load_case.regime != core::Regime::large)
        support::refuse(foundation, "models of small deformations know no foundation; write regime = \"large\"");
    const auto has_key = [&reading](const char *key) { return reading.table.contains(key); };
    if (reading.load_case.scale_to_target ||
        std::ranges::any_of(std::array{"history", "release", "tool", "needle"}, has_key))
        support::refuse(foundation, "a foundation bears a body at rest; leave out 'scale_to_target', [history], "
                                    "[release], [tool] and [[needle]]");
}

void read_foundation(const Reading &reading) {
    auto &load_case = reading.load_case;
    const auto &foundation = support::required_table(reading.table, "foundation");
    const auto place = select_facets(foundation, reading.mesh, load_case);
    double stiffness = support::required_number(foundation, "stiffness");
    if (!(stiffness > 0.0))
        support::refuse(*foundation.get("stiffness"),
                        "the 'stiffness' of a foundation is {} N/m^3; it has to be positive", stiffness);
    if (place.tool)
        support::refuse(foundation, "a foundation is as stiff everywhere; leave the 'profile' out");
    if (std::ranges::any_of(place.facets, [&](int f) { return load_case.is_constrained(f); }))
        throw NotOnBody(
            support::place_of(foundation),
            fmt::format("'{}' has a part that a [[condition]] constrains, where no foundation is felt", place.name),
            "choose a place beside it, or rest = true");
    if (place.area) // facets do not have the area of a disc, and its springs together are as stiff on every mesh
        stiffness *= *place.area / area_of(place.facets, reading.mesh);
    load_case.foundation = core::Foundation{.facets = place.facets,
                                            .stiffness = stiffness,
                                            .normal_only = support::optional_flag(foundation, "normal_only")};
}

} // namespace

namespace events {

/// Springs that a place stands on.
EventReader foundation() {
    return {.name = {},
            .what = "has an elastic foundation",
            .folder = nullptr,
            .quantities = {.has_place = true},
            .required = {"stiffness"},
            .refuse_company = refuse_company_of_foundation,
            .read = read_foundation};
}

} // namespace events

} // namespace livermark::load_cases
