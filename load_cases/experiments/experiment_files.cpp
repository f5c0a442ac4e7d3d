#include "load_cases/experiments/experiment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/ranges.h>
#include <memory>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/experiments/markers.hpp"
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

Vector3 optional_vector(const toml::table &table, const char *key) {
    return table.contains(key) ? support::required_vector(table, key) : Vector3::Zero();
}

core::TetraMesh moved(core::TetraMesh mesh, const Vector3 &by) {
    for (auto &point : mesh.points)
        point += by;
    return mesh;
}

/// Takes the body of a table and says how to make it.
void read_body(const toml::table &table, const std::filesystem::path &file, Experiment &experiment) {
    const auto &body = support::required_table(table, "body");
    support::refuse_unknown_keys(body, {"box", "cylinder", "file"});
    if (body.size() != 1)
        support::refuse(body, "a body is one of box, cylinder and file; leave one of them in");
    if (body.contains("file")) {
        if (table.contains("material"))
            support::refuse(*table.get("material"), "a body of a file has its materials there; leave [material] out");
        const auto path = file.parent_path() / support::required_string(body, "file");
        experiment.body = [path](double) { return meshes::read_body(path); };
        return;
    }
    const auto material = meshes::read_material(support::required_table(table, "material"));
    std::function<core::TetraMesh(double)> mesh;
    if (body.contains("box")) {
        const auto &box = support::required_table(body, "box");
        support::refuse_unknown_keys(box, {"size", "edge_length", "corner"});
        experiment.edge_length = support::required_number(box, "edge_length");
        const auto size = support::required_vector(box, "size");
        experiment.expected_tetrahedra = [=](double edge) {
            return meshes::expected_tetrahedra(meshes::side_of_cube_like_box(size, edge), edge);
        };
        mesh = [size, corner = optional_vector(box, "corner")](double edge) {
            return moved(meshes::generate_box(size, edge, meshes::BoxTopology::body_centred), corner);
        };
    } else {
        const auto &cylinder = support::required_table(body, "cylinder");
        support::refuse_unknown_keys(cylinder, {"radius", "height", "edge_length", "base"});
        experiment.edge_length = support::required_number(cylinder, "edge_length");
        const double radius = support::required_number(cylinder, "radius");
        const double height = support::required_number(cylinder, "height");
        experiment.expected_tetrahedra = [=](double edge) {
            return meshes::expected_tetrahedra(meshes::side_of_cube_like_cylinder(radius, height, edge), edge);
        };
        mesh = [radius, height, base = optional_vector(cylinder, "base")](double edge) {
            return moved(meshes::generate_cylinder(radius, height, edge), base);
        };
    }
    experiment.body = [mesh, material, name = experiment.name](double edge) {
        return core::Body{.name = name, .mesh = mesh(edge), .materials = {material}};
    };
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
        const auto column = std::ranges::find(markers.states, name);
        if (column == markers.states.end())
            support::refuse(*state.get("name"), "the markers have no state '{}'; they have {}", support::shown(name),
                            fmt::join(markers.states, ", "));
        if (std::ranges::find(experiment.states, name, &MeasuredState::name) != experiment.states.end())
            support::refuse(state, "state '{}' occurs twice; leave one out", name);
        experiment.states.push_back({name,
                                     [file, s](const core::TetraMesh &mesh) {
                                         auto again = parse(file);
                                         return load_case_of_state(std::move(*states_of(again)[s].as_table()), file,
                                                                   mesh);
                                     },
                                     markers.displacement[column - markers.states.begin()], noise});
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
    const auto file = toml_file.parent_path() / support::required_string(table, "markers");
    const auto markers = read_markers(file, unit_of(table));
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

namespace {

const std::array<PublicExperiment, 2> public_experiments{
    {{.name = "dragon_skin_beam",
      .title = "Dragon Skin beam: a clamped beam of silicone under weights at its tip",
      .data = "dragon_skin_beam",
      .source = "Dubied et al. 2022, arXiv:2201.12560; python/realbeam_experiments/Measurement_data/ of "
                "github.com/srl-ethz/diffPD_sim2real",
      .licence = "MIT",
      .files = {{"dragon_skin_beam/beam_gravity_V2_a.c3d",
                 "c457a77b67925b9a9d66bbdbd4424a2b8a27e7dfeea2355d75cdc80b1b2e4361"},
                {"dragon_skin_beam/beam_gravity_V2_b.c3d",
                 "cb720b7911214e9a055a5f374cd6979923aa8f1f55afbe98ac5ae0422d6f669e"},
                {"dragon_skin_beam/beam_load52_V2_a.c3d",
                 "bbaeb9ed77cfa38485e5f6b60da25c49876a5ee6f7f1c7cb08dd1962740e52dc"},
                {"dragon_skin_beam/beam_load52_V2_b.c3d",
                 "7379f3dac8f3f28bc37cae68c0515824a76070b6a486c0cd22d0c89c512fdc87"},
                {"dragon_skin_beam/beam_load101_V2_a.c3d",
                 "4fbc73464e67a8edbae316e50253c0a2d5c32047e00320460796aa2ddfaf8e34"},
                {"dragon_skin_beam/beam_load101_V2_b.c3d",
                 "0a0b57dd85a00219abd8dd7ac0d312fa52580032ce575621e78e503cd85bfc28"}}},
     {.name = "truth_cube",
      .title = "Truth Cube: beads in a cube of silicone that plates press together",
      .data = "truth_cube/uniaxial_positions.csv",
      .source = "Kerdok et al. 2003, Med. Image Anal. 7(3); SurgSim/Physics/RenderTests/Data/ of "
                "github.com/simquest/opensurgsim",
      .licence = "Apache-2.0, as that repository",
      .files = {
          {"truth_cube/uniaxial_positions.csv", "046207017370b11e910fffc5a83a85901a1392ca45510dbcbf54f4a6be89efab"}}}}};

std::vector<Vector3> vectors_of(const toml::array &numbers) {
    std::vector<Vector3> vectors(numbers.size() / 3);
    for (std::size_t i = 0; i < numbers.size(); ++i)
        vectors[i / 3][static_cast<Eigen::Index>(i % 3)] = numbers[i].value<double>().value();
    return vectors;
}

/// A box at a corner, whose edges have about the length that is asked for.
std::function<core::Body(double)> body_of(const toml::table &data, const std::string &name) {
    const core::Material material{.density = support::required_number(data, "density"),
                                  .young_modulus = support::required_number(data, "young_modulus"),
                                  .poisson_ratio = support::required_number(data, "poisson_ratio")};
    return [=, size = support::required_vector(data, "size"),
            corner = support::required_vector(data, "corner")](double edge_length) {
        core::Body body{.name = name,
                        .mesh = meshes::generate_box(size, edge_length, meshes::BoxTopology::body_centred),
                        .materials = {material}};
        for (auto &point : body.mesh.points)
            point += corner;
        return body;
    };
}

std::function<core::LoadCase(const core::TetraMesh &)> load_case_of(const toml::table &state, const char *key,
                                                                    const std::string &experiment) {
    return [text = support::required_string(state, key), name = support::required_string(state, "name"),
            file = experiment + ".toml"](const core::TetraMesh &mesh) {
        auto made = load_cases::parse_load_case(text, file, mesh);
        made.name = name;
        return made;
    };
}

RingDown ring_down_of(const toml::table &state, const Experiment &experiment, const std::string &name) {
    RingDown ring_down{.state = support::required_string(state, "name"),
                       .repeats = {},
                       .body = experiment.body,
                       .load_case = load_case_of(state, "held", name)};
    for (const auto &motion : *state["motions"].as_array())
        ring_down.repeats.push_back({support::required_number(state, "interval"),
                                     static_cast<int>(experiment.markers.size()), vectors_of(*motion.as_array())});
    if (const double mass = support::required_number(state, "added_mass"); mass > 0.0)
        ring_down.body = [=, body = experiment.body, low = support::required_vector(state, "low"),
                          high = support::required_vector(state, "high")](double edge_length) {
            return with_added_mass(body(edge_length), mass, low, high);
        };
    return ring_down;
}

/// The answer of python/livermark/studies/public_data.py.
Experiment experiment_of(const toml::table &data, const std::string &name) {
    Experiment experiment;
    experiment.assumptions = support::required_strings(data, "assumptions");
    experiment.body = body_of(data, name);
    experiment.edge_length = support::required_number(data, "edge_length");
    experiment.damping_from = support::required_string(data, "damping_from");
    const auto names = support::required_strings(data, "markers"), drives = support::required_strings(data, "drives");
    const auto positions = vectors_of(*data["positions"].as_array());
    for (std::size_t k = 0; k < names.size(); ++k)
        experiment.markers.push_back({names[k], positions[k], drives[k]});
    for (const auto &entry : *data["state"].as_array()) {
        const auto &state = *entry.as_table();
        experiment.states.push_back({.name = support::required_string(state, "name"),
                                     .load_case = load_case_of(state, "load_case", name),
                                     .displacement = vectors_of(*state["displacement"].as_array()),
                                     .noise = support::required_number(state, "noise")});
        if (state.contains("motions"))
            experiment.ring_downs.push_back(ring_down_of(state, experiment, name));
    }
    return experiment;
}

/// A folder that an environment variable names; empty where it names none.
std::filesystem::path folder_in_environment(const char *name) {
    const char *folder = std::getenv(name); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    return folder ? folder : "";
}

/// The folder of public data in the data directory of the user; empty where there is no home.
std::filesystem::path own_folder() {
    const auto data = folder_in_environment("XDG_DATA_HOME"), home = folder_in_environment("HOME");
    if (data.is_absolute()) // others are to be ignored
        return data / "livermark" / "experiments";
    return home.empty() ? home : home / ".local" / "share" / "livermark" / "experiments";
}

/// The first of data_folders() that has some data.
std::optional<std::filesystem::path> folder_with(const std::string &data, const std::filesystem::path &given) {
    std::error_code ignored;
    for (const auto &folder : data_folders(given))
        if (std::filesystem::exists(folder / data, ignored))
            return folder;
    return std::nullopt;
}

} // namespace

std::span<const PublicExperiment> all_public_data() {
    return public_experiments;
}

std::vector<std::filesystem::path> data_folders(const std::filesystem::path &given) {
    std::vector<std::filesystem::path> folders;
    const auto add = [&](const std::filesystem::path &folder) {
        if (!folder.empty())
            folders.push_back(folder);
    };
    add(given);
    add(folder_in_environment("LIVERMARK_EXPERIMENTS"));
    add(own_folder());
    return folders;
}

std::optional<std::filesystem::path> public_data(const std::string &data, const std::filesystem::path &given) {
    if (const auto folder = folder_with(data, given))
        return *folder / data;
    return std::nullopt;
}

std::string where_to_put(const std::string &data) {
    const auto own = own_folder();
    return own.empty()
               ? fmt::format("set the environment variable LIVERMARK_EXPERIMENTS to the folder that {} is in", data)
               : fmt::format("put {} into {}, or set the environment variable LIVERMARK_EXPERIMENTS to the folder that "
                             "it is in",
                             data, own.string());
}

std::string where_to_get(const PublicExperiment &experiment) {
    return fmt::format("the data of {} are not there; get them from {}, and {}, or give that folder as --data",
                       experiment.name, experiment.source, where_to_put(experiment.data));
}

Experiment read_public(const PublicExperiment &experiment, const std::filesystem::path &given) {
    const auto folder = folder_with(experiment.data, given);
    if (!folder)
        throw support::InputError(where_to_get(experiment));
    const auto data = *folder / experiment.data;
    std::vector<std::string> words{experiment.name, data.string()};
    for (const auto &file : experiment.files) {
        words.push_back((*folder / file.path).string());
        words.push_back(file.sha256);
    }
    const auto answer =
        support::run_python("studies.public_data", words, {}, "an experiment of public data", "python3-numpy");
    auto result = experiment_of(support::parse_toml(answer, experiment.name + ".toml"), experiment.name);
    result.name = experiment.name;
    result.title = experiment.title;
    result.source = experiment.source;
    check(result, data.string());
    return result;
}

} // namespace livermark::experiments
