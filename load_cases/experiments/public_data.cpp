#include <array>
#include <cstdlib>
#include <filesystem>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

const std::array<PublicExperiment, 2> public_experiments{
    {{.name = "dragon_skin_beam",
      .title = "Dragon Skin beam: a clamped beam of silicone under weights at its tip",
      .data = "dragon_skin_beam",
      .source = "Dubied et al. 2022, arXiv:2201.12560; python/realbeam_experiments/ of "
                "github.com/srl-ethz/diffPD_sim2real, MIT"},
     {.name = "truth_cube",
      .title = "Truth Cube: beads in a cube of silicone that plates press together",
      .data = "truth_cube/uniaxial_positions.csv",
      .source = "Kerdok et al. 2003, Med. Image Anal. 7(3); SurgSim/Physics/RenderTests/Data/ of "
                "github.com/simquest/opensurgsim"}}};

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

} // namespace

std::span<const PublicExperiment> all_public_data() {
    return public_experiments;
}

std::filesystem::path data_folder() {
    const char *folder = std::getenv("LIVERMARK_EXPERIMENTS"); // NOLINT(concurrency-mt-unsafe): nobody changes it
    return folder ? std::filesystem::path(folder)
                  : (support::root_folder() / ".." / "shared" / "experiments").lexically_normal();
}

bool has_data(const PublicExperiment &experiment) {
    std::error_code ignored;
    return std::filesystem::exists(data_folder() / experiment.data, ignored);
}

Experiment read_public(const PublicExperiment &experiment) {
    const auto data = data_folder() / experiment.data;
    if (!has_data(experiment))
        throw support::InputError("{}: the data of experiment {} are not there; get them from {}, and put them there "
                                  "or say in LIVERMARK_EXPERIMENTS which folder {} is in",
                                  data.string(), experiment.name, experiment.source, experiment.data);
    const auto answer = support::run_python("studies.public_data", {experiment.name, data.string()}, {},
                                            "an experiment of public data", "python3-numpy");
    auto result = experiment_of(support::parse_toml(answer, experiment.name + ".toml"), experiment.name);
    result.name = experiment.name;
    result.title = experiment.title;
    result.source = experiment.source;
    check(result, data.string());
    return result;
}

} // namespace livermark::experiments
