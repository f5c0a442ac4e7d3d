#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/ranges.h>
#include <limits>
#include <memory>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/experiments/markers.hpp"
#include "load_cases/experiments/solids.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/io/body_reader.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

constexpr int largest_degree = 6;

toml::table parse(const std::filesystem::path &file) {
    auto table = support::parse_toml(support::read_text(file), file);
    support::refuse_unknown_keys(table, {"title", "source", "assumptions", "markers", "unit", "noise", "fit_degree",
                                         "body", "material", "state"});
    return table;
}

double unit_of(const toml::table &table) {
    if (!table.contains("unit"))
        support::required_string(table, "unit"); // which says so
    return support::metres_per_unit(table);
}

/// Takes the body of a table and says how to make it.
void read_body(const toml::table &table, const std::filesystem::path &file, Experiment &experiment) {
    const auto &body = support::required_table(table, "body");
    support::refuse_unknown_keys(body, {"box", "cylinder", "sphere", "file", "finer"});
    const std::size_t num_keys = body.contains("finer") ? 2 : 1;
    if (body.size() != num_keys || (body.contains("finer") && !body.contains("file")))
        support::refuse(body, "a body is one of box, cylinder, sphere and file, which alone has 'finer'; leave one of "
                              "them in");
    if (!body.contains("file"))
        return read_solid(body, material_of(support::required_table(table, "material")), experiment);
    if (table.contains("material"))
        support::refuse(*table.get("material"), "a body of a file has its materials there; leave [material] out");
    const auto body_from = [&](const char *key) {
        return [path = file.parent_path() / support::required_string(body, key)](double) {
            return meshes::read_body(path);
        };
    };
    experiment.body = body_from("file");
    if (body.contains("finer"))
        experiment.finer_body = body_from("finer");
}

toml::array &states_of(toml::table &table) {
    auto *states = table.get("state");
    if (!states || !states->is_array_of_tables())
        support::refuse(table, "there is no [[state]]; add one for each state of the markers");
    return *states->as_array();
}

/// The load case of a state, whose keys a load case knows but for the name. Tables that are moved keep their lines.
core::LoadCase load_case_of_state(toml::table state, const std::filesystem::path &file, const core::TetraMesh &mesh) {
    const auto name = support::required_string(state, "name");
    state.erase("name");
    state.erase("ring_down");
    state.erase("force");
    if (!state.contains("title"))
        state.insert("title", name);
    if (!state.contains("regime"))
        state.insert("regime", "large");
    state.insert("target_peak_displacement", 1.0); // nothing is scaled to it
    auto load_case = load_cases::load_case_of_table(state, file, mesh);
    load_case.name = name;
    load_case.definition = support::read_text(file);
    return load_case;
}

/// The load case of a ring-down: that of its state, and what holds the body until it is let go.
core::LoadCase load_case_of_ring_down(toml::table state, const std::filesystem::path &file,
                                      const core::TetraMesh &mesh) {
    support::required_table(support::required_table(state, "ring_down"), "held"); // says if there is none
    auto held = std::move(*state.get("ring_down")->as_table()->get("held")->as_table());
    if (!state.contains("condition"))
        state.insert("condition", toml::array{});
    if (auto *conditions = state.get("condition")->as_array())
        conditions->push_back(std::move(held));
    return load_case_of_state(std::move(state), file, mesh);
}

/// Whether a load case has a traction.
bool has_traction(const core::LoadCase &load_case) {
    return std::ranges::any_of(load_case.conditions, &core::Condition::is_traction);
}

core::Body body_of_ring_down(const toml::table &table, core::Body body) {
    if (!table.contains("added_mass"))
        return body;
    const auto &added = support::required_table(table, "added_mass");
    support::refuse_unknown_keys(added, {"mass", "low", "high"});
    const double mass = support::required_number(added, "mass");
    if (!(mass > 0.0))
        support::refuse(added, "the added mass is {} kg; it has to be positive", mass);
    return with_added_mass(std::move(body), mass, support::required_vector(added, "low"),
                           support::required_vector(added, "high"));
}

void read_ring_down(const toml::table &state, std::size_t number, const std::filesystem::path &file, double unit,
                    Experiment &experiment) {
    const auto &table = support::required_table(state, "ring_down");
    support::refuse_unknown_keys(table, {"motions", "held", "added_mass", "damping_from"});
    for (const auto &marker : experiment.markers)
        if (!marker.drives.empty())
            support::refuse(table,
                            "marker {} drives a place, and a body that rings down has none that is driven; leave the "
                            "markers there out",
                            marker.name);
    RingDown ring_down{.state = experiment.states[number].name, .repeats = {}, .body = {}, .load_case = {}};
    for (const auto &name : support::required_strings(table, "motions")) {
        const auto motion = read_motion(file.parent_path() / name, experiment.markers, unit);
        if (!ring_down.repeats.empty() && (motion.num_records() != ring_down.repeats.front().num_records() ||
                                           std::abs(motion.interval / ring_down.repeats.front().interval - 1.0) > 1e-3))
            support::refuse(*table.get("motions"),
                            "{} has other times than the first of the motions; cut them to the same records", name);
        ring_down.repeats.push_back(motion);
    }
    const auto table_of_state = [file, number](toml::table &again) -> toml::table & {
        return *states_of(again)[number].as_table();
    };
    ring_down.body = [file, table_of_state, body = experiment.body](double edge_length) {
        auto again = parse(file);
        return body_of_ring_down(support::required_table(table_of_state(again), "ring_down"), body(edge_length));
    };
    ring_down.load_case = [file, table_of_state](const core::TetraMesh &mesh) {
        auto again = parse(file);
        return load_case_of_ring_down(std::move(table_of_state(again)), file, mesh);
    };
    const auto body = ring_down.body(experiment.edge_length);
    if (has_traction(experiment.states[number].load_case(body.mesh)))
        support::refuse(table,
                        "all forces are let go at the start of a ring-down, and state '{}' has some that stay; give "
                        "what hangs at the body as added_mass",
                        support::shown(ring_down.state));
    if (!has_traction(ring_down.load_case(body.mesh)))
        support::refuse(table, "'held' is not a force; give it a place and a force");
    if (experiment.damping_from.empty() || support::optional_flag(table, "damping_from"))
        experiment.damping_from = ring_down.state;
    experiment.ring_downs.push_back(std::move(ring_down));
}

MeasuredForce read_force(const toml::table &table, const std::filesystem::path &file, double unit) {
    support::refuse_unknown_keys(table, {"table", "place", "fit_at", "compare_at", "parts", "length"});
    auto ways = support::required_numbers(table, "compare_at");
    ways.insert(ways.begin(), support::required_number(table, "fit_at"));
    auto force = read_force_table(file.parent_path() / support::required_string(table, "table"), unit, std::move(ways));
    force.place = support::required_string(table, "place");
    if (table.contains("parts"))
        force.parts = support::required_number(table, "parts");
    if (table.contains("length"))
        force.length = support::required_number(table, "length");
    return force;
}

void read_states(toml::table &table, const std::filesystem::path &file, const MarkerTable &markers,
                 Experiment &experiment) {
    double noise = 0.0;
    if (table.contains("noise") && !((noise = support::required_number(table, "noise")) >= 0.0))
        support::refuse(*table.get("noise"), "the noise is {} m; it has to be 0 or more", noise);
    auto &states = states_of(table);
    for (std::size_t s = 0; s < states.size(); ++s) {
        const auto &state = *states[s].as_table();
        const auto name = support::required_string(state, "name");
        for (const char *key : {"release", "tool", "scale_to_target", "target_peak_displacement"})
            if (state.contains(key))
                support::refuse(*state.get(key), "a state is at rest under what was done to the body; leave '{}' out",
                                key);
        const bool has_force = state.contains("force");
        if (has_force && state.contains("path"))
            support::refuse(*state.get("path"), "a state with a force has the points of its table as its path; leave "
                                                "'path' out");
        const auto column = std::ranges::find(markers.states, name);
        const bool has_markers = column != markers.states.end();
        if (!has_markers && !has_force)
            support::refuse(*state.get("name"), "the markers have no state '{}'; they have {}", support::shown(name),
                            markers.states.empty() ? "none" : fmt::format("{}", fmt::join(markers.states, ", ")));
        if (std::ranges::find(experiment.states, name, &MeasuredState::name) != experiment.states.end())
            support::refuse(state, "state '{}' occurs twice; leave one out", name);
        const std::vector<Vector3> not_seen(markers.names.size(),
                                            Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
        MeasuredState measured{name,
                               [file, s](const core::TetraMesh &mesh) {
                                   auto again = parse(file);
                                   return load_case_of_state(std::move(*states_of(again)[s].as_table()), file, mesh);
                               },
                               has_markers ? markers.displacement[column - markers.states.begin()] : not_seen, noise};
        if (has_force)
            measured.force = read_force(support::required_table(state, "force"), file, unit_of(table));
        experiment.states.push_back(std::move(measured));
    }
}

} // namespace

Experiment read_experiment(const std::filesystem::path &toml_file,
                           const std::function<void(const std::string &)> &say) {
    auto table = parse(toml_file);
    Experiment experiment;
    experiment.name = toml_file.stem().string();
    experiment.title = support::required_string(table, "title");
    experiment.source = support::required_string(table, "source");
    if (table.contains("assumptions"))
        experiment.assumptions = support::required_strings(table, "assumptions");
    if (table.contains("fit_degree")) {
        const double degree = support::required_number(table, "fit_degree");
        if (degree != std::round(degree) || degree < 0.0 || degree > largest_degree)
            support::refuse(*table.get("fit_degree"), "'fit_degree' is a whole number from 0 to {}", largest_degree);
        experiment.fit_degree = static_cast<int>(degree);
    }
    read_body(table, toml_file, experiment);
    if (say && experiment.expected_tetrahedra && experiment.edge_length > 0.0)
        say(fmt::format("{}: a mesh of {}", experiment.name,
                        meshes::text_of_expected_tetrahedra(experiment.expected_tetrahedra(experiment.edge_length))));
    const bool has_markers =
        table.contains("markers") || !std::ranges::all_of(states_of(table), [](const toml::node &state) {
            return state.as_table()->contains("force");
        });
    const auto file = has_markers ? toml_file.parent_path() / support::required_string(table, "markers") : toml_file;
    const auto markers = has_markers ? read_markers(file, unit_of(table)) : MarkerTable{};
    for (std::size_t k = 0; k < markers.names.size(); ++k)
        experiment.markers.push_back({markers.names[k], markers.rest[k], markers.drives[k]});
    read_states(table, toml_file, markers, experiment);
    auto &states = states_of(table);
    for (std::size_t s = 0; s < states.size(); ++s)
        if (states[s].as_table()->contains("ring_down"))
            read_ring_down(*states[s].as_table(), s, toml_file, unit_of(table), experiment);
    check(experiment, file.string());
    return experiment;
}

} // namespace livermark::experiments
