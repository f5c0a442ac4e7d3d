#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <vector>

#include "core/events.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"

namespace livermark::load_cases {

namespace {

/// The tables [foundation] or [[foundation]].
std::vector<const toml::table *> foundations(const Reading &reading) {
    const auto &node = *reading.table.get("foundation");
    const auto *list = node.as_array();
    if (!list)
        return {&support::required_table(reading.table, "foundation")};
    std::vector<const toml::table *> tables;
    for (const auto &entry : *list) {
        if (!entry.is_table())
            support::refuse(entry, "each [[foundation]] has to be a table with a place and a 'stiffness'");
        tables.push_back(entry.as_table());
    }
    if (tables.empty())
        support::refuse(node, "'foundation' is empty; give a place and a 'stiffness', or leave it out");
    return tables;
}

void refuse_company_of_foundation(const Reading &reading) {
    const auto tables = foundations(reading);
    for (const auto *table : tables)
        support::refuse_unknown_keys(*table, keys_with_place({"name", "stiffness", "normal_only"}));
    const auto &foundation = *tables.front();
    const auto has_key = [&reading](const char *key) { return reading.table.contains(key); };
    if (reading.load_case.scale_to_target ||
        std::ranges::any_of(std::array{"history", "release", "tool", "needle"}, has_key))
        support::refuse(foundation, "a foundation bears a body at rest; leave out 'scale_to_target', [history], "
                                    "[release], [tool] and [[needle]]");
}

/// Part of its area that a place gives up to conditions at most.
constexpr double most_lost = 0.25;

/// Springs below a facet.
struct FacetSprings {
    double stiffness;
    bool normal_only;
};

/// Adds one place to those that have springs already, whose facets keep theirs.
void add_foundation(const Reading &reading, const toml::table &foundation, std::map<int, FacetSprings> &springs) {
    auto &load_case = reading.load_case;
    auto place = select_facets(foundation, reading.mesh, load_case);
    if (foundation.contains("name"))
        place.name = support::required_string(foundation, "name");
    double stiffness = support::required_number(foundation, "stiffness");
    if (!(stiffness > 0.0))
        support::refuse(*foundation.get("stiffness"),
                        "the 'stiffness' of a foundation is {} N/m^3; it has to be positive", stiffness);
    if (place.tool)
        support::refuse(foundation, "a foundation is as stiff everywhere; leave the 'profile' out");
    std::vector<int> facets;
    std::ranges::copy_if(place.facets, std::back_inserter(facets), [&](int f) { return !load_case.is_constrained(f); });
    const double lost_area = 1.0 - area_of(facets, reading.mesh) / area_of(place.facets, reading.mesh);
    if (lost_area > most_lost)
        throw NotOnBody(support::place_of(foundation),
                        fmt::format("{:.0f} % of '{}' is where a [[condition]] constrains, and no foundation is felt",
                                    100.0 * lost_area, place.name),
                        "choose a place beside it, or rest = true");
    if (facets.size() < place.facets.size())
        load_case.yielded.push_back({place.name, lost_area});
    if (place.area) // facets do not have the area of a disc, and its springs together are as stiff on every mesh
        stiffness *= *place.area / area_of(place.facets, reading.mesh);
    const FacetSprings below{stiffness, support::optional_flag(foundation, "normal_only")};
    for (const int facet : facets)
        springs.emplace(facet, below);
}

void read_foundation(const Reading &reading) {
    std::map<int, FacetSprings> springs;
    for (const auto *foundation : foundations(reading))
        add_foundation(reading, *foundation, springs);
    auto &found = reading.load_case.foundation.emplace();
    for (const auto &[facet, below] : springs) {
        found.facets.push_back(facet);
        found.stiffness.push_back(below.stiffness);
        found.normal_only.push_back(below.normal_only ? 1 : 0);
    }
}

} // namespace

namespace events {

/// Springs that places stand on.
EventReader foundation() {
    return {.name = {},
            .what = "has an elastic foundation",
            .folder = "load_cases/supported",
            .quantities = {.has_place = true},
            .required = {"stiffness"},
            .refuse_company = refuse_company_of_foundation,
            .read = read_foundation};
}

} // namespace events

} // namespace livermark::load_cases
