#include "results/hdf5/load_case_group.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>

#include "results/facet_arrays.hpp"
#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/node_numbers.hpp"

namespace livermark::results::hdf5 {

namespace {

void write_release(OutputFile &file, const core::Release &release) {
    std::vector<std::array<int, 1>> probe;
    std::vector<std::string> names;
    for (const core::Probe &entry : release.probes) {
        probe.push_back({entry.node});
        names.push_back(entry.name);
    }
    file.group("/load_case/release");
    file.integer("/load_case/release", "num_steps", release.num_steps);
    file.number("/load_case/release", "output_interval", release.output_interval);
    file.integer("/load_case/release", "records_per_frame", release.records_per_frame());
    file.number("/load_case/release", "alpha", release.damping.alpha);
    file.number("/load_case/release", "beta", release.damping.beta);
    file.dataset("/load_case/release/probe", probe, "");
    file.texts("/load_case/release/probe", "names", names);
}

void write_round_loads(OutputFile &file, const FacetArrays &facets) {
    std::vector<core::Vector3> middle;
    std::vector<double> radius;
    for (const auto &load : facets.round_loads) {
        middle.push_back(load.middle);
        radius.push_back(load.radius);
    }
    file.group("/load_case/round_load");
    file.dataset("/load_case/round_load/facet", facets.round_load, "");
    file.dataset("/load_case/round_load/middle", middle, "m");
    file.dataset("/load_case/round_load/radius", radius, "m");
}

void write_slow_history(OutputFile &file, const core::SlowHistory &history) {
    const std::string group = "/load_case/slow_history";
    file.group(group);
    file.text(group, "relaxation", history.relaxation.name);
    if (history.last_cycle)
        file.integer(group, "last_cycle", *history.last_cycle);
    file.dataset(group + "/modulus", history.relaxation.moduli, "");
    file.dataset(group + "/relaxation_time", history.relaxation.times, "s");
    file.dataset(group + "/time", history.times, "s");
    file.dataset(group + "/factor", history.factors, "");
}

core::SlowHistory read_slow_history(const InputFile &file) {
    const std::string group = "/load_case/slow_history";
    core::SlowHistory history;
    history.relaxation.name = file.text(group, "relaxation");
    history.relaxation.moduli = file.dataset<double>(group + "/modulus");
    history.relaxation.times = file.dataset<double>(group + "/relaxation_time", history.relaxation.moduli.size());
    const auto is_negative = [](double value) { return !(value >= 0.0); };
    if (std::ranges::any_of(history.relaxation.moduli, is_negative) || !(history.relaxation.remaining() > 0.0) ||
        std::ranges::any_of(history.relaxation.times, is_negative))
        file.refuse(group, "is no Prony series: its moduli have to be 0 or more and their sum below 1, its times 0 or "
                           "more");
    history.times = file.dataset<double>(group + "/time");
    history.factors = file.dataset<double>(group + "/factor", history.times.size());
    if (history.times.size() < 2 || history.times.front() != 0.0 || !std::isfinite(history.times.back()) ||
        std::ranges::adjacent_find(history.times, [](double a, double b) { return !(a < b); }) != history.times.end())
        file.refuse(group + "/time", "does not ascend from 0");
    if (history.factors.front() != 0.0 ||
        !std::ranges::all_of(history.factors, [](double factor) { return factor >= 0.0 && factor <= 1.0; }))
        file.refuse(group + "/factor", "is not from 0 to 1, beginning with 0");
    if (file.has_attribute(group, "last_cycle")) {
        const auto record = file.integer(group, "last_cycle");
        if (record < 0 || record >= history.num_records())
            file.refuse(group, fmt::format("attribute last_cycle is {}, which is no record", record));
        history.last_cycle = static_cast<int>(record);
    }
    return history;
}

void write_touch(OutputFile &file, const core::TouchingTool &ball) {
    file.group("/load_case/touch");
    file.integer("/load_case/touch", "constraint", ball.constraint);
    file.number("/load_case/touch", "radius", ball.radius);
    file.number("/load_case/touch", "friction", ball.friction);
    file.dataset("/load_case/touch/way", std::vector{ball.start, ball.press, ball.slide}, "m");
}

core::TouchingTool read_touch(const InputFile &file, std::size_t num_constraints) {
    const std::string group = "/load_case/touch";
    core::TouchingTool ball;
    const auto constraint = file.integer(group, "constraint");
    if (constraint < 0 || constraint >= static_cast<std::int64_t>(num_constraints))
        file.refuse(group, fmt::format("attribute constraint is {}", constraint));
    ball.constraint = static_cast<int>(constraint);
    ball.radius = file.number(group, "radius");
    ball.friction = file.number(group, "friction");
    if (!(ball.radius > 0.0 && ball.friction >= 0.0 && std::isfinite(ball.radius) && std::isfinite(ball.friction)))
        file.refuse(group, "attributes radius and friction have to be positive, or friction zero");
    const auto way = file.dataset<core::Vector3>(group + "/way", 3);
    check_finite(file, group + "/way", way);
    ball.start = way[0];
    ball.press = way[1];
    ball.slide = way[2];
    if (ball.press.isZero(0.0))
        file.refuse(group + "/way", "does not press");
    return ball;
}

core::Release read_release(const InputFile &file, std::size_t num_nodes) {
    const std::string group = "/load_case/release";
    core::Release release;
    const auto num_steps = file.integer(group, "num_steps");
    if (num_steps < 1 || num_steps >= std::numeric_limits<int>::max())
        file.refuse(group, fmt::format("attribute num_steps is {}", num_steps));
    release.num_steps = static_cast<int>(num_steps);
    if (const auto found = file.integer(group, "records_per_frame"); found != release.records_per_frame())
        file.refuse(group,
                    fmt::format("attribute records_per_frame is {} instead of {}", found, release.records_per_frame()));
    release.output_interval = file.number(group, "output_interval");
    release.damping = {file.number(group, "alpha"), file.number(group, "beta")};
    if (!(release.output_interval > 0.0 && release.damping.alpha >= 0.0 && release.damping.beta >= 0.0))
        file.refuse(group, "attributes output_interval, alpha and beta have to be positive, or the last two zero");
    const auto names = file.texts(group + "/probe", "names");
    const auto nodes = node_numbers<1>(file, group + "/probe", num_nodes);
    if (names.empty() || nodes.size() != names.size())
        file.refuse(group + "/probe", fmt::format("has {} nodes and {} names", nodes.size(), names.size()));
    for (std::size_t q = 0; q < names.size(); ++q)
        release.probes.push_back({names[q], nodes[q][0]});
    return release;
}

core::Regime read_regime(const InputFile &file) {
    const auto word = file.text("/load_case", "regime");
    for (const auto regime : {core::Regime::small, core::Regime::large})
        if (word == core::to_string(regime))
            return regime;
    file.refuse("/load_case", fmt::format("attribute regime is '{}', which is neither small nor large", word));
}

void read_round_loads(const InputFile &file, std::size_t num_triangles, FacetArrays &facets) {
    const auto radius = file.dataset<double>("/load_case/round_load/radius");
    const auto middle = file.dataset<core::Vector3>("/load_case/round_load/middle", radius.size());
    check_finite(file, "/load_case/round_load/middle", middle);
    for (std::size_t k = 0; k < radius.size(); ++k) {
        if (!(radius[k] > 0.0 && std::isfinite(radius[k])))
            file.refuse("/load_case/round_load/radius", fmt::format("row {} is no length", k));
        facets.round_loads.push_back({middle[k], radius[k]});
    }
    facets.round_load = indices(file, "/load_case/round_load/facet", num_triangles, -1, radius.size());
}

/// What is on each facet.
/// @param presses  whether tractions with a constraint press
FacetArrays read_facets(const InputFile &file, std::size_t num_triangles, bool presses) {
    FacetArrays facets;
    for (const std::uint8_t code : file.dataset<std::uint8_t>("/load_case/condition", num_triangles)) {
        if (code > static_cast<std::uint8_t>(FacetCode::traction))
            file.refuse("/load_case/condition",
                        fmt::format("row {} holds {}, which is no condition", facets.condition.size(), code));
        facets.condition.push_back(static_cast<FacetCode>(code));
    }
    facets.constraint_names = file.texts("/load_case/constraint", "names");
    facets.constraint = indices(file, "/load_case/constraint", num_triangles, -1, facets.constraint_names.size());
    for (std::size_t f = 0; f < num_triangles; ++f) {
        const bool is_named = facets.constraint[f] >= 0;
        const bool may_press = presses && facets.condition[f] == FacetCode::traction;
        if ((facets.condition[f] == FacetCode::prescribed_displacement) != is_named && !may_press)
            file.refuse("/load_case/constraint", fmt::format("row {} contradicts /load_case/condition", f));
    }
    if (file.has("/load_case/load")) { // files of earlier versions have none
        facets.load_names = file.texts("/load_case/load", "names");
        facets.load = indices(file, "/load_case/load", num_triangles, -1, facets.load_names.size());
        for (std::size_t f = 0; f < num_triangles; ++f) {
            const bool is_given = facets.condition[f] == FacetCode::traction && facets.constraint[f] < 0;
            if (is_given != (facets.load[f] >= 0))
                file.refuse("/load_case/load", fmt::format("row {} contradicts /load_case/condition", f));
        }
    }
    if (file.has("/load_case/follows"))
        facets.follows = file.dataset<std::uint8_t>("/load_case/follows", num_triangles);
    if (file.has("/load_case/round_load"))
        read_round_loads(file, num_triangles, facets);
    return facets;
}

} // namespace

void write_load_case(OutputFile &file, const core::LoadCase &load_case) {
    file.group("/load_case");
    file.text("/load_case", "name", load_case.name);
    file.text("/load_case", "title", load_case.title);
    file.text("/load_case", "definition", load_case.definition);
    file.text("/load_case", "regime", core::to_string(load_case.regime));
    file.number("/load_case", "target_peak_displacement", load_case.target_peak_displacement);
    file.number("/load_case", "load_scale", load_case.load_scale);
    const auto facets = facet_arrays(load_case);
    std::vector<std::uint8_t> condition;
    for (const FacetCode code : facets.condition)
        condition.push_back(static_cast<std::uint8_t>(code));
    file.dataset("/load_case/condition", condition, "");
    file.dataset("/load_case/value", load_case.value, "m or Pa");
    const core::Vector3 &a = load_case.acceleration;
    file.dataset("/load_case/acceleration", std::vector{a.x(), a.y(), a.z()}, "m/s^2");
    file.dataset("/load_case/constraint", facets.constraint, "");
    file.texts("/load_case/constraint", "names", facets.constraint_names);
    if (!facets.load.empty()) {
        file.dataset("/load_case/load", facets.load, "");
        file.texts("/load_case/load", "names", facets.load_names);
    }
    if (load_case.press_depth != 0.0)
        file.number("/load_case", "press_depth", load_case.press_depth);
    if (!facets.follows.empty())
        file.dataset("/load_case/follows", facets.follows, "");
    if (!load_case.node_factor.empty())
        file.dataset("/load_case/node_factor", load_case.node_factor, "");
    if (!load_case.node_shift.empty())
        file.dataset("/load_case/node_shift", load_case.node_shift, "m");
    if (!facets.round_load.empty())
        write_round_loads(file, facets);
    if (!load_case.path.empty())
        file.dataset("/load_case/path", load_case.path, "");
    if (!load_case.yielded.empty()) {
        std::vector<double> lost_areas;
        std::vector<std::string> names;
        for (const auto &place : load_case.yielded) {
            lost_areas.push_back(place.lost_area);
            names.push_back(place.name);
        }
        file.dataset("/load_case/yielded", lost_areas, "");
        file.texts("/load_case/yielded", "names", names);
    }
    if (load_case.touching)
        write_touch(file, *load_case.touching);
    if (load_case.release)
        write_release(file, *load_case.release);
    if (load_case.slow_history)
        write_slow_history(file, *load_case.slow_history);
}

core::LoadCase read_load_case(const InputFile &file, std::size_t num_triangles, std::size_t num_nodes) {
    core::LoadCase load_case;
    load_case.name = file.text("/load_case", "name");
    load_case.title = file.text("/load_case", "title");
    load_case.definition = file.text("/load_case", "definition");
    load_case.target_peak_displacement = file.number("/load_case", "target_peak_displacement");
    if (file.has_attribute("/load_case", "load_scale")) // files of before there was scaling have none
        load_case.load_scale = file.number("/load_case", "load_scale");
    if (file.has_attribute("/load_case", "regime")) // files of before there was another have none
        load_case.regime = read_regime(file);
    load_case.value = file.dataset<core::Vector3>("/load_case/value", num_triangles);
    const auto acceleration = file.dataset<double>("/load_case/acceleration", 3);
    load_case.acceleration = core::Vector3(acceleration[0], acceleration[1], acceleration[2]);
    check_finite(file, "/load_case/acceleration", {&load_case.acceleration, 1});
    if (file.has_attribute("/load_case", "press_depth"))
        load_case.press_depth = file.number("/load_case", "press_depth");
    if (!std::isfinite(load_case.press_depth))
        file.refuse("/load_case", "attribute press_depth is not a number");
    const auto facets = read_facets(file, num_triangles, load_case.press_depth != 0.0);
    if (file.has("/load_case/node_factor")) {
        load_case.node_factor = file.dataset<double>("/load_case/node_factor", num_nodes);
        if (!std::ranges::all_of(load_case.node_factor,
                                 [](double factor) { return factor >= 0.0 && std::isfinite(factor); }))
            file.refuse("/load_case/node_factor", "holds what is not a number from 0");
    }
    if (file.has("/load_case/node_shift")) {
        load_case.node_shift = file.dataset<core::Vector3>("/load_case/node_shift", num_nodes);
        check_finite(file, "/load_case/node_shift", load_case.node_shift);
    }
    if (file.has("/load_case/path")) {
        load_case.path = file.dataset<double>("/load_case/path");
        if (load_case.path.empty() || !(load_case.path.front() > 0.0) || load_case.path.back() != 1.0 ||
            std::ranges::adjacent_find(load_case.path, std::greater_equal<>()) != load_case.path.end())
            file.refuse("/load_case/path", "does not ascend from above 0 to 1");
    }
    if (file.has("/load_case/yielded")) {
        const auto names = file.texts("/load_case/yielded", "names");
        const auto lost = file.dataset<double>("/load_case/yielded", names.size());
        for (std::size_t y = 0; y < names.size(); ++y) {
            if (!(lost[y] > 0.0 && lost[y] < 1.0))
                file.refuse("/load_case/yielded", fmt::format("row {} is no part of an area", y));
            load_case.yielded.push_back({names[y], lost[y]});
        }
    }
    if (file.has("/load_case/touch"))
        load_case.touching = read_touch(file, facets.constraint_names.size());
    if (const auto contradiction = set_conditions(facets, load_case))
        file.refuse("/load_case", *contradiction);
    if (file.has("/load_case/release"))
        load_case.release = read_release(file, num_nodes);
    if (file.has("/load_case/slow_history"))
        load_case.slow_history = read_slow_history(file);
    return load_case;
}

} // namespace livermark::results::hdf5
