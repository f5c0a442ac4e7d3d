#include "results/facet_arrays.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace livermark::results {

namespace {

using core::Condition;
using core::ConditionKind;

FacetCode code_of(const Condition *condition) {
    if (!condition)
        return FacetCode::free;
    return condition->is_traction() ? FacetCode::traction : FacetCode::prescribed_displacement;
}

/// A condition, and the facet that it was seen on first; -1 if on none.
struct SeenCondition {
    Condition condition;
    int round = -1; ///< index of its round load
    int facet = -1;
};

/// What the rows say of one facet.
SeenCondition seen_on(const FacetArrays &facets, int f) {
    SeenCondition seen{.condition = {}, .facet = f};
    auto &kind = seen.condition.kind;
    const bool is_traction = facets.condition[f] == FacetCode::traction;
    if (is_traction && facets.constraint[f] >= 0)
        kind = ConditionKind::press;
    else if (is_traction)
        kind = !facets.follows.empty() && facets.follows[f] != 0 ? ConditionKind::pressure : ConditionKind::traction;
    if (is_traction && !facets.round_load.empty() && facets.round_load[f] >= 0) {
        seen.round = facets.round_load[f];
        seen.condition.round = facets.round_loads[seen.round];
    }
    return seen;
}

/// The places whose force is a result, and those with a given one, each as its first facet has it.
struct SeenPlaces {
    std::vector<SeenCondition> constraints, loads;
    std::vector<int> place; ///< (T) index into one of them, -1 where a facet is free
    std::optional<std::string> contradiction{};
};

/// The place of a facet whose load has no name: that of the others with the same condition.
int unnamed_load(std::vector<SeenCondition> &loads, const SeenCondition &here) {
    const auto number =
        static_cast<std::size_t>(std::ranges::find(loads, here.condition, &SeenCondition::condition) - loads.begin());
    if (number == loads.size())
        loads.push_back(here);
    return static_cast<int>(number);
}

SeenPlaces seen_places(const FacetArrays &facets, int touched) {
    SeenPlaces seen;
    for (const auto &name : facets.constraint_names)
        seen.constraints.push_back({.condition = {.place = name}});
    if (touched >= 0)
        seen.constraints[touched].condition.kind = ConditionKind::touch;
    for (const auto &name : facets.load_names)
        seen.loads.push_back({.condition = {.place = name}});
    for (int f = 0; f < static_cast<int>(facets.condition.size()); ++f) {
        if (facets.condition[f] == FacetCode::free) {
            seen.place.push_back(-1);
            continue;
        }
        auto here = seen_on(facets, f);
        const bool is_constraint = facets.constraint[f] >= 0;
        seen.place.push_back(is_constraint         ? facets.constraint[f]
                             : facets.load.empty() ? unnamed_load(seen.loads, here)
                                                   : facets.load[f]);
        auto &place = (is_constraint ? seen.constraints : seen.loads)[seen.place.back()];
        here.condition.place = place.condition.place;
        if (place.facet < 0)
            place = std::move(here);
        else if (here.condition != place.condition)
            seen.contradiction =
                fmt::format("rows {} and {} are of one place, and have different conditions", place.facet, f);
    }
    return seen;
}

/// Whether the next of two is the first, so that round loads keep their numbers.
bool is_before(const SeenCondition &first, const SeenCondition &second) {
    return first.round < 0 || (second.round >= 0 && first.round < second.round);
}

} // namespace

FacetArrays facet_arrays(const core::LoadCase &load_case) {
    FacetArrays arrays;
    arrays.constraint_names = load_case.constraint_names();
    arrays.load_names = load_case.load_names();
    arrays.round_loads = load_case.round_loads();
    const auto num_facets = load_case.condition_on.size();
    const bool has_names =
        std::ranges::any_of(arrays.load_names, [](const std::string &name) { return !name.empty(); });
    if (has_names)
        arrays.load.assign(num_facets, -1);
    if (load_case.has(ConditionKind::pressure))
        arrays.follows.assign(num_facets, 0);
    if (!arrays.round_loads.empty())
        arrays.round_load.assign(num_facets, -1);
    std::vector<int> number_of_round;
    int num_round = 0;
    for (const auto &condition : load_case.conditions)
        number_of_round.push_back(condition.round ? num_round++ : -1);
    for (int f = 0; f < load_case.num_facets(); ++f) {
        arrays.condition.push_back(code_of(load_case.on(f)));
        arrays.constraint.push_back(load_case.constraint_on(f));
        if (has_names)
            arrays.load[f] = load_case.load_on(f);
        if (load_case.follows_surface(f))
            arrays.follows[f] = 1;
        if (load_case.round_load_on(f))
            arrays.round_load[f] = number_of_round[load_case.condition_on[f]];
    }
    return arrays;
}

std::optional<std::string> set_conditions(const FacetArrays &facets, core::LoadCase &load_case) {
    const auto contact = load_case.contact();
    const auto seen = seen_places(facets, contact ? contact->constraint : -1);
    if (seen.contradiction)
        return seen.contradiction;
    std::vector<int> constraint_at, load_at;
    while (constraint_at.size() < seen.constraints.size() || load_at.size() < seen.loads.size()) {
        const bool takes_constraint = load_at.size() == seen.loads.size() ||
                                      (constraint_at.size() < seen.constraints.size() &&
                                       is_before(seen.constraints[constraint_at.size()], seen.loads[load_at.size()]));
        auto &at = takes_constraint ? constraint_at : load_at;
        const auto &next = (takes_constraint ? seen.constraints : seen.loads)[at.size()];
        at.push_back(static_cast<int>(load_case.conditions.size()));
        load_case.conditions.push_back(next.condition);
    }
    for (std::size_t f = 0; f < facets.condition.size(); ++f) {
        const bool is_constraint = facets.constraint[f] >= 0;
        load_case.condition_on.push_back(seen.place[f] < 0 ? -1
                                                           : (is_constraint ? constraint_at : load_at)[seen.place[f]]);
    }
    return std::nullopt;
}

} // namespace livermark::results
