#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "core/support/input_error.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"

namespace livermark::load_cases {

namespace {

/// A history beyond this was asked for by a slip of the unit.
constexpr double most_steps = 1e6;
/// Part of an output interval by which the duration may miss a whole number of them.
constexpr double rounding_of_times = 1e-6;

double number_above(const toml::table &table, std::string_view key, double least, bool least_allowed) {
    const double value = support::required_number(table, key);
    if (value < least || (value == least && !least_allowed))
        support::refuse(*table.get(key), "'{}' is {}; it has to be {}", key, value,
                        least_allowed ? "zero or more" : "positive");
    return value;
}

/// Angular frequencies of two positive frequencies in hertz.
std::array<double, 2> read_frequencies(const toml::table &table) {
    const auto *array = table.get("damping_frequencies")->as_array();
    if (!array || array->size() != 2)
        support::refuse(*table.get("damping_frequencies"), "'damping_frequencies' has to be two numbers in brackets");
    std::array<double, 2> omega{};
    for (std::size_t i = 0; i < 2; ++i) {
        const auto frequency = array->get(i)->value<double>().value_or(0.0);
        if (!(frequency > 0.0) || !std::isfinite(frequency))
            support::refuse(*array, "'damping_frequencies' have to be positive and finite numbers");
        omega[i] = 2.0 * std::numbers::pi * frequency;
    }
    return omega;
}

core::RayleighDamping read_damping(const toml::table &table) {
    const bool by_ratio = table.contains("damping_ratio") && table.contains("damping_frequencies");
    const bool by_coefficients = table.contains("alpha") && table.contains("beta");
    if (by_ratio == by_coefficients || table.contains("damping_ratio") == table.contains("alpha") ||
        table.contains("damping_frequencies") == table.contains("beta"))
        support::refuse(table, "damping is given either by 'damping_ratio' and 'damping_frequencies' or by 'alpha' and "
                               "'beta'; give one of the two pairs");
    if (by_coefficients)
        return {number_above(table, "alpha", 0.0, true), number_above(table, "beta", 0.0, true)};
    const double ratio = number_above(table, "damping_ratio", 0.0, true);
    const auto [first, second] = read_frequencies(table);
    return core::rayleigh_damping(ratio, first, second);
}

bool is_constrained(int node, const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_constrained(f) && !load_case.value[f].array().isNaN().any() &&
            std::ranges::find(mesh.boundary_triangles[f], node) != mesh.boundary_triangles[f].end())
            return true;
    return false;
}

std::vector<core::Probe> read_probes(const toml::table &table, const core::TetraMesh &mesh,
                                     const core::LoadCase &load_case) {
    const auto *node = table.get("probe");
    if (!node || !node->is_array_of_tables())
        support::refuse(*table.get("release"),
                        "a release without a [[probe]] records nothing; add one with a name and a patch");
    std::vector<core::Probe> probes;
    for (const auto &entry : *node->as_array()) {
        const auto &probe = *entry.as_table();
        support::refuse_unknown_keys(probe, {"name", "patch"});
        const auto name = support::required_string(probe, "name");
        if (name.empty() || std::ranges::find(probes, name, &core::Probe::name) != probes.end())
            support::refuse(probe, "every probe needs a name that no other has, and '{}' is not one", name);
        probes.push_back({name, select_node(probe, mesh)});
        if (is_constrained(probes.back().node, mesh, load_case))
            throw NotOnBody(support::place_of(probe), fmt::format("probe '{}' is at a constrained node", name),
                            "choose a patch that moves");
    }
    return probes;
}

core::Release release_of(const toml::table &table, const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    const auto &release = support::required_table(table, "release");
    support::refuse_unknown_keys(
        release, {"duration", "output_interval", "damping_ratio", "damping_frequencies", "alpha", "beta"});
    if (std::ranges::none_of(load_case.conditions, &core::Condition::is_traction))
        support::refuse(release, "there is no load to release; add a [[condition]] with a traction or a pressure");
    const double duration = number_above(release, "duration", 0.0, false);
    const double interval = number_above(release, "output_interval", 0.0, false);
    const double num_steps = std::round(duration / interval);
    if (num_steps < 1.0 || num_steps > most_steps || std::abs(duration / interval - num_steps) > rounding_of_times)
        support::refuse(
            release,
            "a duration of {} s is not a whole number, from 1 to {}, of output intervals of {} s; change one of them",
            duration, most_steps, interval);
    return {static_cast<int>(num_steps), interval, read_damping(release), read_probes(table, mesh, load_case)};
}

void read_release(const Reading &reading) {
    const auto &[table, file, mesh, load_case] = reading;
    if (table.contains("release"))
        load_case.release = release_of(table, mesh, load_case);
    else
        support::refuse(
            *table.get("probe"),
            "a [[probe]] records motion, and nothing moves without a [release]; add one or remove the probe");
}

void look_for_damping_and_probe(const toml::table &load_case, std::vector<std::string> &missing) {
    const auto &release = *load_case["release"].as_table();
    if (!release.contains("damping_ratio") && !release.contains("damping_frequencies") && !release.contains("alpha") &&
        !release.contains("beta"))
        missing.emplace_back("'damping_ratio' and 'damping_frequencies' in the [release]");
    if (!load_case.contains("probe"))
        missing.emplace_back("a [[probe]] with a name and a patch");
}

} // namespace

namespace events {

/// Tractions that are let go, and probes of the motion.
EventReader release() {
    return {.name = {},
            .what = "has a release",
            .folder = nullptr,
            .in_time = true,
            .beside = {"probe"},
            .required = {"duration", "output_interval"},
            .look_for_missing = look_for_damping_and_probe,
            .read = read_release};
}

} // namespace events

} // namespace livermark::load_cases
