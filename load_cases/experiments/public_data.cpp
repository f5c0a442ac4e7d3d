#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/experiments/solids.hpp"
#include "load_cases/readers/load_case_reader.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

/// A mixture of silicone, and the digest of its ten files behind each other, in the order of their names.
struct Mixture {
    const char *name, *sha256;
};
constexpr std::array<Mixture, 19> mixtures{{
    {"EF10_0T", "a251275fbdf4dbe78c508ebd073915ddb0f038ae9daa1a0112c324b36a26ed13"},
    {"EF10_100T", "8ae84bb2da208f51b2f756d7f3ea5f3832de20cef7111f0f2e4df7fe13c24430"},
    {"EF10_12_5T", "f3f871ec85598a3f39e47dd4906d2c08d0f2ad3eb769e3c9928c6212bca1f5c5"},
    {"EF10_25T", "9173aa3443ca9c882f7656aea1dd9d6532b40cc715aa2c15440711ea6d4b4156"},
    {"EF10_37_5T", "5b589d9d0df860de6581b9d3f8111fac6609b03612f8f63d17ce0c261a2ee381"},
    {"EF10_50T", "ace7c8d0d85df175b2803313c666f9719e3a32618d0aea60c88637ee20f54df2"},
    {"EF10_62_5T", "611f2b40ffe60e8647899414ce6d884defc965fc8ef9b8299c4f739e2e76b238"},
    {"EF10_75T", "833fd3f8f70f9111eb1b7ccaca32b02983048b36647f7bbd5c13509343310aeb"},
    {"EF10_87_5T", "99da74628137aba4ea9313fed93f0d0a98f74bfa0e1434010bb001bbbb903e4b"},
    {"EF30_0T", "ee387df601375ddf19fbfd1a6a87714cc315ea84ea73ef9056cf03aa9b4959d5"},
    {"EF30_12_5T", "9528ccd3955458d1e4fdc055be47d7a3c6e30749b737b48a9abcbd70f940c7fe"},
    {"EF30_25T", "f38465ea3be20acb26fae3f54f694d90ac5e1063550037ea505897eed6ed6c16"},
    {"EF30_37_5T", "38bc37c17d01ee0924cdc136a136dce8b66da2dcc59308bfbbedd2ccbcdf6d91"},
    {"EF30_50T", "d4b50cf425df0b7dbbc512f21fde8806d6315e98b541f4704b5b88cd3efbf7bf"},
    {"EF50_0T", "359a5a0d5a7a1f45374b0f14211325c1258b2d31fa3b9c54f85c689097867e0b"},
    {"EF50_12_5T", "3ef1aa45ee679afad18e2e3f65e077e53792cab3a7633c082103c5687849fd3c"},
    {"EF50_25T", "1fce2bb8e22ccf1ef9bc90cfa05b89fa8e52fba26c01a4ed853d14e06c7985ac"},
    {"EF50_37_5T", "2e9e2c7d014e4a0d24bbf045953cccda848896ff7b1d85690ca296ad2a51ede0"},
    {"EF50_50T", "b5fd481de999ceaf6ab07f7633da88df997cdda47661e1cce8db4c774a43b8ae"},
}};

std::vector<PublicExperiment> public_experiments() {
    std::vector<PublicExperiment> all{
        {.name = "dragon_skin_tension",
         .title = "Force on a strip of Dragon Skin 10 that is pulled: the silicone of the beam, or one like it",
         .data = "dragon_skin_tension/Dragon Skin 10 MEDIUM.csv",
         .source = "Marechal et al. 2020, Soft Robotics, 10.1089/soro.2019.0115; Tensile-Tests-Data/ of "
                   "github.com/LucMarechal/Soft-Robotics-Materials-Database",
         .licence = "ODbL 1.0",
         .files = {{"dragon_skin_tension/Dragon Skin 10 MEDIUM.csv",
                    "01cbda9d2aabe7bd32aa16f0464ece700ab5872a8e225948c9a3fa91f00cbbf2"}}},
        {.name = "dragon_skin_beam",
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
         .files = {{"truth_cube/uniaxial_positions.csv",
                    "046207017370b11e910fffc5a83a85901a1392ca45510dbcbf54f4a6be89efab"}}}};
    for (const auto &[mixture, sha256] : mixtures)
        all.push_back({.name = fmt::format("ecoflex_{}", mixture),
                       .title = fmt::format("Force on a cylinder of silicone, {}, between two plates", mixture),
                       .data = fmt::format("ecoflex_cylinders/{}", mixture),
                       .source =
                           "Dawood et al. 2026, Hyperelastic Characterisation of Silicone Tissue Phantoms; data/ of "
                           "github.com/abubakardawood/tissue-phantom-material-database",
                       .licence = "CC BY 4.0",
                       .files = {{fmt::format("ecoflex_cylinders/{}", mixture), sha256}}});
    std::ranges::sort(all, {}, &PublicExperiment::name);
    return all;
}

std::vector<Vector3> vectors_of(const toml::array &numbers) {
    std::vector<Vector3> vectors(numbers.size() / 3);
    for (std::size_t i = 0; i < numbers.size(); ++i)
        vectors[i / 3][static_cast<Eigen::Index>(i % 3)] = numbers[i].value<double>().value();
    return vectors;
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

/// The force of a state of that answer.
MeasuredForce force_of(const toml::table &force) {
    return {.place = support::required_string(force, "place"),
            .way = support::required_numbers(force, "way"),
            .force = support::required_numbers(force, "force"),
            .deviation = support::required_numbers(force, "deviation"),
            .parts = support::required_number(force, "parts"),
            .length = support::required_number(force, "length")};
}

/// The answer of python/livermark/studies/public_data.py.
Experiment experiment_of(const toml::table &data, const std::string &name) {
    Experiment experiment;
    experiment.name = name;
    experiment.assumptions = support::required_strings(data, "assumptions");
    read_solid(data, material_of(support::required_table(data, "material")), experiment);
    experiment.damping_from = support::required_string(data, "damping_from");
    if (data.contains("markers")) {
        const auto names = support::required_strings(data, "markers"),
                   drives = support::required_strings(data, "drives");
        const auto positions = vectors_of(*data["positions"].as_array());
        for (std::size_t k = 0; k < names.size(); ++k)
            experiment.markers.push_back({names[k], positions[k], drives[k]});
    }
    for (const auto &entry : *data["state"].as_array()) {
        const auto &state = *entry.as_table();
        experiment.states.push_back({.name = support::required_string(state, "name"),
                                     .load_case = load_case_of(state, "load_case", name),
                                     .displacement = vectors_of(*state["displacement"].as_array()),
                                     .noise = support::required_number(state, "noise")});
        if (state.contains("force"))
            experiment.states.back().force = force_of(support::required_table(state, "force"));
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

/// The first of data_folders() that has some data, and where they are there: a summary of a folder is a file.
struct FoundData {
    std::filesystem::path folder, place;
};
std::optional<FoundData> find_data(const std::string &data, const std::filesystem::path &given) {
    std::error_code ignored;
    for (const auto &folder : data_folders(given))
        for (const auto *ending : {"", ".csv"})
            if (const auto place = folder / (data + ending); std::filesystem::exists(place, ignored))
                return FoundData{folder, place};
    return std::nullopt;
}

} // namespace

std::span<const PublicExperiment> all_public_data() {
    static const auto all = public_experiments();
    return all;
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
    const auto found = find_data(data, given);
    return found ? std::optional(found->place) : std::nullopt;
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
    const auto found = find_data(experiment.data, given);
    if (!found)
        throw support::InputError(where_to_get(experiment));
    std::vector<std::string> words{experiment.name, found->place.string()};
    for (const auto &file : experiment.files) {
        words.push_back((found->folder / file.path).string());
        words.push_back(file.sha256);
    }
    const auto answer =
        support::run_python("studies.public_data", words, {}, "an experiment of public data", "python3-numpy");
    auto result = experiment_of(support::parse_toml(answer, experiment.name + ".toml"), experiment.name);
    result.title = experiment.title;
    result.source = experiment.source;
    check(result, found->place.string());
    return result;
}

} // namespace livermark::experiments
