#include "results/hdf5/solution_group.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <tuple>
#include <type_traits>

#include "results/hdf5/record_file.hpp"
#include "results/hdf5/references.hpp"

namespace livermark::results::hdf5 {

namespace {

using core::Condition;
using core::ConditionKind;

bool is_from_zero(double value) {
    return value >= 0.0 && std::isfinite(value);
}

/// Sizes of what events number.
struct EventBounds {
    std::size_t num_nodes, num_constraints, num_facets;
};

template <class At> void describe_event(At at, Of<At, core::Release> &release, const EventBounds &bounds) {
    constexpr int most_steps = std::numeric_limits<int>::max() - 50;
    at.integer("num_steps", release.num_steps, 1, most_steps);
    at.number("output_interval", release.output_interval);
    int records_per_frame = release.records_per_frame();
    at.integer("records_per_frame", records_per_frame);
    at.check(
        records_per_frame == release.records_per_frame(),
        fmt::format("attribute records_per_frame is {} instead of {}", records_per_frame, release.records_per_frame()));
    at.number("alpha", release.damping.alpha);
    at.number("beta", release.damping.beta);
    at.check(release.output_interval > 0.0 && release.damping.alpha >= 0.0 && release.damping.beta >= 0.0,
             "attributes output_interval, alpha and beta have to be positive, or the last two zero");
    std::vector<std::array<int, 1>> nodes;
    for (const auto &probe : release.probes)
        nodes.push_back({probe.node});
    at.node_numbers("probe", nodes, bounds.num_nodes);
    at.check(!nodes.empty(), "probe", "is empty");
    auto probes = columns_of(at.on("probe"), release.probes, nodes.size());
    probes.texts("names", &core::Probe::name);
    if constexpr (At::reads)
        for (std::size_t q = 0; q < nodes.size(); ++q)
            release.probes[q].node = nodes[q][0];
}

template <class At> void describe_event(At at, Of<At, core::SlowHistory> &history, const EventBounds & /*bounds*/) {
    auto &relaxation = history.relaxation;
    at.text("relaxation", relaxation.name);
    at.rows("modulus", relaxation.moduli);
    at.rows("relaxation_time", relaxation.times, "s", relaxation.moduli.size());
    const auto is_zero_or_more = [](double value) { return value >= 0.0; };
    at.check(std::ranges::all_of(relaxation.moduli, is_zero_or_more) && relaxation.remaining() > 0.0 &&
                 std::ranges::all_of(relaxation.times, is_zero_or_more),
             "is no Prony series: its moduli have to be 0 or more and their sum below 1, its times 0 or more");
    at.rows("time", history.times, "s");
    at.rows("factor", history.factors, "", history.times.size());
    at.check(history.times.size() >= 2 && history.times.front() == 0.0 && std::isfinite(history.times.back()) &&
                 std::ranges::adjacent_find(history.times, [](double a, double b) { return !(a < b); }) ==
                     history.times.end(),
             "time", "does not ascend from 0");
    at.check(history.factors.front() == 0.0 &&
                 std::ranges::all_of(history.factors, [](double factor) { return factor >= 0.0 && factor <= 1.0; }),
             "factor", "is not from 0 to 1, beginning with 0");
    at.optional("last_cycle", history.last_cycle,
                [&](auto &record) { at.integer("last_cycle", record, 0, history.num_records() - 1); });
}

template <class At> void describe_event(At at, Of<At, core::TouchingTool> &ball, const EventBounds &bounds) {
    at.integer("constraint", ball.constraint, 0, static_cast<std::int64_t>(bounds.num_constraints) - 1);
    at.number("radius", ball.shape.radius);
    if (at.has("face", ball.shape.is_plate())) {
        at.word("face", ball.shape.face);
        at.number("size", ball.shape.size);
        at.check(ball.shape.size > 0.0 && std::isfinite(ball.shape.size), "attribute size has to be positive");
    }
    at.number("friction", ball.friction);
    at.check(ball.shape.radius > 0.0 && std::isfinite(ball.shape.radius) && is_from_zero(ball.friction),
             "attributes radius and friction have to be positive, or friction zero");
    at.rows_of("way", "m", ball.start, ball.press, ball.slide);
    at.finite("way", std::array{ball.start, ball.press, ball.slide});
    at.check(!ball.press.isZero(0.0), "way", "does not press");
    at.optional("between", ball.between, [&](auto &middle) {
        at.rows("between", middle, "m");
        at.finite("between", {&middle, 1});
        at.check(!ball.shape.is_plate() && ball.slide.isZero(0.0) &&
                     ball.constraint + 1 < static_cast<int>(bounds.num_constraints),
                 "between", "needs a ball that does not slide, and a constraint after its own");
    });
    if constexpr (At::reads)
        if (ball.shape.is_plate())
            ball.shape = {ball.shape.face, ball.shape.size, ball.shape.radius, ball.press};
}

template <class At> void describe_event(At at, Of<At, core::Foundation> &foundation, const EventBounds &bounds) {
    auto &facets = foundation.facets;
    at.rows("facet", facets);
    at.rows("stiffness", foundation.stiffness, "N/m^3", facets.size());
    at.check(std::ranges::all_of(foundation.stiffness, [](double k) { return k > 0.0 && std::isfinite(k); }),
             "stiffness", "has to be positive");
    at.rows("normal_only", foundation.normal_only, "", facets.size());
    at.within("normal_only", foundation.normal_only, 0, 2);
    at.within("facet", facets, 0, bounds.num_facets);
    at.check(!facets.empty() && std::ranges::adjacent_find(facets, std::greater_equal<>()) == facets.end(), "facet",
             "does not ascend");
}

template <class At> void describe_round_loads(At at, Of<At, FacetArrays> &facets, std::size_t num_triangles) {
    auto columns = columns_of(at, facets.round_loads);
    columns.column("middle", &core::RoundLoad::middle, "m");
    columns.column("radius", &core::RoundLoad::radius, "m");
    for (std::size_t k = 0; k < facets.round_loads.size(); ++k) {
        at.finite("middle", {&facets.round_loads[k].middle, 1});
        at.check(facets.round_loads[k].radius > 0.0 && std::isfinite(facets.round_loads[k].radius), "radius",
                 fmt::format("row {} is no length", k));
    }
    at.rows("facet", facets.round_load, "", num_triangles);
    at.within("facet", facets.round_load, -1, facets.round_loads.size());
}

/// @param presses  whether tractions with a constraint press
void check_places(const GroupReader &at, const FacetArrays &facets, bool presses) {
    for (std::size_t f = 0; f < facets.condition.size(); ++f) {
        const bool is_named = facets.constraint[f] >= 0, is_traction = facets.condition[f] == traction_facet;
        const bool is_moved = facets.condition[f] == prescribed_facet;
        const auto fault = [&] { return fmt::format("row {} contradicts /load_case/condition", f); };
        if (is_moved != is_named && !(presses && is_traction))
            at.check(false, "constraint", fault());
        if (!facets.load.empty() && (is_traction && !is_named) != (facets.load[f] >= 0))
            at.check(false, "load", fault());
    }
}

/// The motion of a tool is in files of its own, see write_tool_scene().
template <class At>
void describe_events(At at, Of<At, core::LoadCase> &load_case, bool in_time, const EventBounds &bounds) {
    const auto describe = [&](auto &event) {
        using Kind = std::decay_t<decltype(*event)>;
        if constexpr (!std::is_same_v<Kind, core::ToolMotion>)
            if (Kind::in_time == in_time)
                at.optional(Kind::key, event, [&](auto &found) { describe_event(at.group(Kind::key), found, bounds); });
    };
    std::apply([&](auto &...event) { (describe(event), ...); }, load_case.events());
}

/// A condition, and the facet that it was seen on first; -1 if on none.
struct SeenCondition {
    Condition condition;
    int round = -1; ///< index of its round load
    int facet = -1;
};

/// The condition that the rows have on one facet.
SeenCondition seen_on(const FacetArrays &facets, int f) {
    SeenCondition seen{.condition = {}, .facet = f};
    auto &kind = seen.condition.kind;
    const bool is_traction = facets.condition[f] == traction_facet;
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

SeenPlaces seen_places(const FacetArrays &facets, std::span<const core::ExpectedContact> contacts) {
    SeenPlaces seen;
    for (const auto &name : facets.constraint_names)
        seen.constraints.push_back({.condition = {.place = name}});
    for (const auto &contact : contacts)
        seen.constraints[static_cast<std::size_t>(contact.constraint)].condition.kind = ConditionKind::touch;
    for (const auto &name : facets.load_names)
        seen.loads.push_back({.condition = {.place = name}});
    for (int f = 0; f < static_cast<int>(facets.condition.size()); ++f) {
        if (facets.condition[f] == free_facet) {
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

/// Gives a load case the conditions that the rows came from.
/// @param load_case  with its events
/// @return what contradicts itself, in words; nothing if all is well
std::optional<std::string> set_conditions(const FacetArrays &facets, core::LoadCase &load_case) {
    const auto seen = seen_places(facets, load_case.contacts());
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

/// @param facets  what is on each, of a load case that is written
template <class At>
void describe_load_case(At at, Of<At, core::LoadCase> &load_case, FacetArrays facets, std::size_t num_triangles,
                        std::size_t num_nodes) {
    at.text("name", load_case.name);
    at.text("title", load_case.title);
    at.text("definition", load_case.definition);
    if (at.has("regime")) // files of before there was another have none
        at.word("regime", load_case.regime);
    at.number("target_peak_displacement", load_case.target_peak_displacement);
    if (at.has("load_scale")) // nor those of before there was scaling
        at.number("load_scale", load_case.load_scale);
    at.rows("condition", facets.condition, "", num_triangles);
    const auto no_code = std::ranges::find_if(facets.condition, [](int code) { return code > traction_facet; });
    if (no_code != facets.condition.end())
        at.check(false, "condition",
                 fmt::format("row {} holds {}, which is no condition", no_code - facets.condition.begin(), *no_code));
    at.rows("value", load_case.value, "m or Pa", num_triangles);
    std::array<double, 3> acceleration{load_case.acceleration.x(), load_case.acceleration.y(),
                                       load_case.acceleration.z()};
    at.rows("acceleration", acceleration, "m/s^2");
    if constexpr (At::reads)
        load_case.acceleration = core::Vector3(acceleration.data());
    at.finite("acceleration", {&load_case.acceleration, 1});
    at.named_indices("constraint", facets.constraint, facets.constraint_names, num_triangles, -1);
    if (at.has("load", !facets.load.empty())) // nor those of earlier versions
        at.named_indices("load", facets.load, facets.load_names, num_triangles, -1);
    if (at.has("press_depth", load_case.press_depth != 0.0))
        at.number("press_depth", load_case.press_depth);
    at.check(std::isfinite(load_case.press_depth), "attribute press_depth is not a number");
    if constexpr (At::reads)
        check_places(at, facets, load_case.press_depth != 0.0);
    if (at.has("follows", !facets.follows.empty()))
        at.rows("follows", facets.follows, "", num_triangles);
    if (at.has("node_factor", !load_case.node_factor.empty()))
        at.rows("node_factor", load_case.node_factor, "", num_nodes);
    at.check(std::ranges::all_of(load_case.node_factor, is_from_zero), "node_factor",
             "holds what is not a number from 0");
    if (at.has("node_shift", !load_case.node_shift.empty()))
        at.rows("node_shift", load_case.node_shift, "m", num_nodes);
    at.finite("node_shift", load_case.node_shift);
    if (at.has("round_load", !facets.round_load.empty()))
        describe_round_loads(at.group("round_load"), facets, num_triangles);
    if (at.has("path", !load_case.path.empty())) {
        at.rows("path", load_case.path);
        at.check(!load_case.path.empty() && load_case.path.front() > 0.0 && load_case.path.back() == 1.0 &&
                     std::ranges::adjacent_find(load_case.path, std::greater_equal<>()) == load_case.path.end(),
                 "path", "does not ascend from above 0 to 1");
    }
    if (at.has("yielded", !load_case.yielded.empty())) {
        columns_of(at, load_case.yielded).column("yielded", &core::YieldedPlace::lost_area);
        columns_of(at.on("yielded"), load_case.yielded, load_case.yielded.size())
            .texts("names", &core::YieldedPlace::name);
        for (std::size_t y = 0; y < load_case.yielded.size(); ++y)
            at.check(load_case.yielded[y].lost_area > 0.0 && load_case.yielded[y].lost_area < 1.0, "yielded",
                     fmt::format("row {} is no part of an area", y));
    }
    const EventBounds bounds{num_nodes, facets.constraint_names.size(), num_triangles};
    describe_events(at, load_case, false, bounds);
    if constexpr (At::reads) {
        const auto contradiction = set_conditions(facets, load_case);
        at.check(!contradiction, contradiction.value_or(""));
    }
    describe_events(at, load_case, true, bounds);
}

} // namespace

void write_load_case(OutputFile &file, const core::LoadCase &load_case) {
    describe_load_case(GroupWriter(file).group("load_case"), load_case, facet_arrays(load_case),
                       load_case.condition_on.size(), load_case.node_factor.size());
}

core::LoadCase read_load_case(const InputFile &file, std::size_t num_triangles, std::size_t num_nodes) {
    core::LoadCase load_case;
    describe_load_case(GroupReader(file).on("load_case"), load_case, {}, num_triangles, num_nodes);
    return load_case;
}

} // namespace livermark::results::hdf5
