#include "app/cli/image_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <sstream>
#include <string_view>

#include "app/cli/body_sources.hpp"
#include "app/cli/commands.hpp"
#include "app/cli/segment_program.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/io/mesh_files.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

fs::path body_file_of(const std::string &output) {
    const fs::path mesh = output;
    if (mesh.extension() != ".msh")
        throw support::InputError(fmt::format("{}: the mesh is written as MSH; end its name in .msh", output));
    support::check_place(mesh);
    auto body = mesh;
    body.replace_extension(".toml");
    return body;
}

/// A command line without the option that only says to do it again.
std::string without_force(const std::string &command_line) {
    std::string words = command_line;
    constexpr std::string_view flag = " --force";
    for (auto at = words.find(flag); at != std::string::npos; at = words.find(flag))
        words.erase(at, flag.size());
    return words;
}

/// The words behind the program, which may be called by several paths.
std::string arguments_of(const std::string &command_line) {
    const auto space = command_line.find(' ');
    return space == std::string::npos ? "" : without_force(command_line).substr(space);
}

/// Looks whether a body is there already.
/// @return its exit status if the same command has made it of the same files; nothing if it is to be made
std::optional<int> made_before(const SegmentCommand &command, const fs::path &body_file) {
    if (command.force || !fs::exists(body_file))
        return std::nullopt;
    const auto body = support::parse_toml(support::read_text(body_file), body_file);
    const auto generator = body["generator"].value_or(std::string());
    const bool is_same = arguments_of(generator) == arguments_of(command.command_line) && fs::exists(command.output);
    if (!is_same)
        throw support::InputError(fmt::format(
            "{}: this body exists already, made by another command; give --force to overwrite it, or another -o",
            body_file.string()));
    const auto before = sources_in(body_file);
    const auto now = sources_of(command);
    if (!before || !before->is_same_body(now))
        throw support::InputError(fmt::format(
            "{}: this body exists already, and {} has changed since; give --force to make it again", body_file.string(),
            fmt::join(command.labels.empty() ? command.surfaces : std::vector{command.labels}, " or ")));
    print_notes(
        {fmt::format("{} exists already, made by the same command; --force makes it again", body_file.string())});
    fmt::print(command.table, "{}", meshes::to_text(meshes::mesh_figures(meshes::read_msh(command.output))));
    int status = 0;
    if (const auto *gates = body["image"]["gates"].as_array())
        for (const auto &gate : *gates)
            if (const auto *table = gate.as_table())
                if (!(*table)["met"].value_or(true) && !(*table)["advice"].value_or(false))
                    status = 1;
    return status;
}

template <class Number> std::string list_of(const std::vector<Number> &numbers) {
    return fmt::format("{}", fmt::join(numbers, ","));
}

int make_body(const SegmentCommand &command, std::vector<std::string> words) {
    const auto body_file = body_file_of(command.output); // refuses before long work
    if (const auto status = made_before(command, body_file))
        return *status;
    words.insert(words.end(),
                 {"--tetrahedra", std::to_string(command.tetrahedra), "--mesh", command.output, "--made-of",
                  sources_toml(sources_of(command)), "--command-line", without_force(command.command_line)});
    const auto [status, output] = segment(std::move(words));
    fmt::print(command.table, "{}", output);
    return status;
}

/// Whether a body file is that of these sources.
bool is_made_of(const BodySources &sources, const fs::path &body_file) {
    try {
        const auto known = sources_in(body_file);
        return known && known->is_same_body(sources);
    } catch (const support::InputError &) {
        return false; // damaged, so nothing to take
    }
}

/// The body file of these sources: the one that is there, or a name that no other body has.
fs::path place_of(const fs::path &folder, const std::string &stem, const BodySources &sources) {
    auto plain = folder / (stem + ".toml");
    std::error_code error;
    if (!fs::exists(plain, error) || is_made_of(sources, plain))
        return plain;
    support::FnvHash hash;
    hash.add(sources.options);
    hash.add(sources.content);
    return folder / fmt::format("{}_{:08x}.toml", stem, static_cast<std::uint32_t>(hash.value() >> 32));
}

/// Body files that are made in the output folder.
class Mesher {
  public:
    Mesher(const std::string &output, const std::string &command_line, bool force)
        : output_(output), command_line_(command_line), force_(force) {}

    /// @param source  for messages
    /// @param make    writes a body
    /// @return the body file
    std::string body_of(const std::string &source, const std::string &stem, const char *option, SegmentCommand command,
                        int (*make)(const SegmentCommand &)) const {
        if (support::started_on_many_ranks())
            throw support::InputError(fmt::format("{}: only one process can mesh a segmentation; mesh it first with "
                                                  "`livermark mesh {}`, and give the body file",
                                                  source, option));
        const studies::OutputFolder output(output_);
        const auto &folder = output.path();
        const auto sources = sources_of(command);
        const auto body_file = place_of(folder, stem, sources);
        const bool has_mesh = fs::exists(fs::path(body_file).replace_extension(".msh"));
        if (has_mesh && is_made_of(sources, body_file) && !force_) {
            fmt::print(stderr, "livermark: {} is used for {}; --force meshes it again\n", body_file.string(), source);
            return body_file.string();
        }
        if (body_file.stem() != stem)
            fmt::print(stderr,
                       "livermark: {} has other content than {}, so this body is called {}; results of both stay\n",
                       (folder / (stem + ".toml")).string(), source, body_file.stem().string());
        command.output = fs::path(body_file).replace_extension(".msh").string();
        command.command_line = command_line_;
        command.force = true;
        command.table = stderr;
        make(command);
        return body_file.string();
    }

  private:
    const std::string &output_, &command_line_;
    bool force_;
};

} // namespace

int make_body_of_labels(const SegmentCommand &command) {
    std::vector<std::string> words{"labels", command.labels};
    if (!command.liver.empty())
        words.insert(words.end(), {"--liver", list_of(command.liver)});
    if (!command.tumours.empty())
        words.insert(words.end(), {"--tumours", list_of(command.tumours)});
    for (const auto &role : command.roles)
        words.push_back("--role=" + role);
    return make_body(command, std::move(words));
}

int make_body_of_surfaces(const SegmentCommand &command) {
    std::vector<std::string> words{"surfaces"};
    words.insert(words.end(), command.surfaces.begin(), command.surfaces.end());
    if (command.unit)
        words.insert(words.end(), {"--unit", *command.unit});
    return make_body(command, std::move(words));
}

void add_stiffness_map(const StiffnessCommand &command, const std::string &command_line) {
    const fs::path output = command.output;
    if (support::file_ending(output) != ".toml")
        throw support::InputError("{}: the body is written as a .toml; end its name so", command.output);
    support::check_place(output);
    if (support::file_ending(command.body) != ".toml")
        throw support::InputError("{}: a map is given to a body that says its materials; write a .toml for it, as "
                                  "docs/reference/load_cases.md shows",
                                  command.body);
    auto table = support::parse_toml(support::read_text(command.body), command.body);
    if (std::error_code error; fs::equivalent(command.body, output, error))
        throw support::InputError("{}: this is the body itself; name another file with -o", command.output);
    if (table.contains("stiffness_map"))
        throw support::InputError("{}: this body has a map of stiffness already; give the body without it",
                                  command.body);
    auto moduli = output;
    moduli.replace_extension(".moduli.txt");
    segment({"stiffness", command.body, "--map", command.map, "--of", command.quantity, "--unit", command.unit,
             "--output", moduli.string()});
    const auto mesh = fs::absolute(fs::path(command.body).parent_path() / support::required_string(table, "mesh"));
    table.insert_or_assign("mesh", fs::relative(mesh, fs::absolute(output).parent_path()).string());
    table.insert_or_assign(
        "stiffness_map",
        toml::table{
            {"file", moduli.filename().string()},
            {"source", fmt::format("{} of {}, {}", command.quantity == "shear" ? "shear modulus" : "Young's modulus",
                                   fs::path(command.map).filename().string(), without_force(command_line))}});
    std::ostringstream text;
    text << table << '\n';
    support::write_whole(output, text.str());
    fmt::print("{} and {} are written; next: livermark run --body {}\n", output.string(), moduli.string(),
               output.string());
}

void write_vessel_lines(VesselsCommand command) {
    if (command.output.empty()) {
        const auto stem = stem_of_image(command.labels);
        if (stem.empty())
            throw support::InputError("{}: this is no name of a label image; give one of NIfTI, NRRD or MetaImage, a "
                                      "DICOM segmentation, or the folder of a DICOM series",
                                      command.labels);
        command.output = stem + ".swc";
    }
    if (support::file_ending(command.output) != ".swc")
        throw support::InputError("{}: lines of vessels are written as SWC; end its name in .swc", command.output);
    support::check_place(command.output);
    std::vector<std::string> words{"vessels", command.labels, "--output", command.output};
    for (const auto &role : command.roles)
        words.push_back("--role=" + role);
    if (command.largest_radius) {
        if (constexpr double most = 0.1; !(*command.largest_radius > 0.0 && *command.largest_radius < most))
            throw support::InputError("--largest-radius is {:g} m; give a length below {:g} m, such as 0.004",
                                      *command.largest_radius, most);
        words.insert(words.end(), {"--largest-radius", fmt::format("{}", *command.largest_radius)});
    }
    fmt::print("{}", segment(std::move(words)).output);
}

std::string figures_of_labels(const std::string &file) {
    return segment({"figures-of-labels", file}).output;
}

std::string figures_of_surface(const std::string &file) {
    return segment({"figures-of-surface", file}).output;
}

int make_phantom(const PhantomCommand &command) {
    for (const double spacing : command.spacing)
        if (!(spacing >= 0.1e-3 && spacing <= 20e-3))
            throw support::InputError(
                fmt::format("--spacing is {} m; give three lengths between 0.0001 and 0.02 m", spacing));
    for (const double angle : command.turn)
        if (constexpr double most = 100.0; !(std::abs(angle) <= most))
            throw support::InputError(
                fmt::format("--turn is {} rad; give three angles, which turn about x, y and z together", angle));
    if (command.vessels && support::file_ending(command.output) != ".nrrd")
        throw support::InputError("{}: this format keeps no names of segments, which --vessels gives; end the name in "
                                  ".nrrd",
                                  command.output);
    std::vector<std::string> words{"phantom", "--output", command.output};
    for (const auto &[option, numbers] :
         {std::pair("--spacing", &command.spacing), std::pair("--turn", &command.turn)}) {
        words.emplace_back(option);
        for (const double number : *numbers)
            words.push_back(fmt::format("{}", number));
    }
    if (command.touching)
        words.emplace_back("--touching");
    if (command.vessels)
        words.emplace_back("--vessels");
    for (const auto &[option, file] :
         {std::pair("--scan", &command.scan), std::pair("--stiffness", &command.stiffness)})
        if (!file->empty()) {
            support::check_place(*file);
            words.insert(words.end(), {option, *file});
        }
    fmt::print("{}", segment(std::move(words)).output);
    return 0;
}

std::string stem_of_image(const std::string &body) {
    const fs::path path = body;
    std::error_code error;
    if (fs::is_directory(path, error) && path.extension() != ".toml")
        return (path.has_filename() ? path : path.parent_path()).filename().string();
    const auto name = path.filename().string();
    const auto lower = support::lower_case(name);
    for (const std::string_view ending :
         {".nii.gz", ".hdr.gz", ".img.gz", ".nii", ".hdr", ".img", ".nrrd", ".nhdr", ".mha", ".mhd", ".dcm"})
        if (name.size() > ending.size() && lower.ends_with(ending))
            return name.substr(0, name.size() - ending.size());
    return {};
}

std::vector<std::string> with_images_meshed(const std::vector<std::string> &bodies, const std::string &output,
                                            const std::string &command_line, bool force) {
    const auto shipped = support::list_toml(support::root_folder() / studies::bodies_folder);
    const Mesher mesher(output, command_line, force);
    std::vector<std::string> surfaces, with_bodies;
    for (const auto &body : bodies) {
        // Where results are kept there are folders with the names of bodies.
        const bool is_shipped = std::ranges::find(shipped, body) != shipped.end();
        if (const auto stem = stem_of_image(body); !stem.empty() && !is_shipped) {
            with_bodies.push_back(
                mesher.body_of(body, stem, "--labels", SegmentCommand{.labels = body}, make_body_of_labels));
        } else if (!is_shipped && meshes::is_surface_file(body)) {
            if (surfaces.empty())
                with_bodies.push_back(body); // for the liver; its lesions follow
            surfaces.push_back(body);
        } else {
            with_bodies.push_back(body);
        }
    }
    if (!surfaces.empty()) {
        const auto stem = fs::path(surfaces.front()).stem().string();
        *std::ranges::find(with_bodies, surfaces.front()) = mesher.body_of(
            surfaces.front(), stem, "--surfaces", SegmentCommand{.surfaces = surfaces}, make_body_of_surfaces);
    }
    return with_bodies;
}

std::vector<std::string> with_images_meshed(const std::vector<std::string> &bodies, const std::string &command_line) {
    return with_images_meshed(bodies, runs_folder(), command_line, false);
}

std::string with_image_meshed(const std::string &body, const std::string &command_line) {
    return with_images_meshed({body}, command_line).front();
}

} // namespace livermark::cli
