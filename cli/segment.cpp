#include "cli/segment.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <unistd.h>

#include "cli/body_sources.hpp"
#include "cli/progress.hpp"
#include "meshes/io/mesh_figures.hpp"
#include "meshes/io/msh_reader.hpp"
#include "support/input_error.hpp"
#include "support/processes/child_process.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

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

/// Lets the program that is linked with ITK and CGAL do something; its errors go where ours go.
/// @return its exit status, 0 or 1, and what it has printed
support::Printed segment(std::vector<std::string> words) {
    const auto program = fs::read_symlink("/proc/self/exe").parent_path() / "livermark-segment";
    if (!fs::exists(program))
        throw support::InputError(
            "bodies of images and surfaces need the program livermark-segment, which is not built here; "
            "build it with scripts/bootstrap --program --segmentation");
    words.insert(words.begin(), {program.string(), "--parent", std::to_string(getpid())});
    auto printed = support::run_printing(words);
    constexpr int refused = 2;
    if (printed.status == refused)
        throw support::InputError(printed.output);
    if (printed.status < 0 || printed.status > refused)
        throw std::runtime_error(
            printed.output.empty()
                ? fmt::format("{} was ended from outside; is there too little memory?", program.string())
                : printed.output);
    return printed;
}

/// What a run is called without what only says to do it again.
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

} // namespace

int make_body_of_labels(const SegmentCommand &command) {
    std::vector<std::string> words{"labels", command.labels};
    if (!command.liver.empty())
        words.insert(words.end(), {"--liver", list_of(command.liver)});
    if (!command.tumours.empty())
        words.insert(words.end(), {"--tumours", list_of(command.tumours)});
    return make_body(command, std::move(words));
}

int make_body_of_surfaces(const SegmentCommand &command) {
    std::vector<std::string> words{"surfaces"};
    words.insert(words.end(), command.surfaces.begin(), command.surfaces.end());
    if (command.unit)
        words.insert(words.end(), {"--unit", *command.unit});
    return make_body(command, std::move(words));
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
    std::vector<std::string> words{"phantom", "--output", command.output};
    for (const auto &[option, numbers] :
         {std::pair("--spacing", &command.spacing), std::pair("--turn", &command.turn)}) {
        words.emplace_back(option);
        for (const double number : *numbers)
            words.push_back(fmt::format("{}", number));
    }
    if (command.touching)
        words.emplace_back("--touching");
    if (!command.scan.empty()) {
        support::check_place(command.scan);
        words.insert(words.end(), {"--scan", command.scan});
    }
    fmt::print("{}", segment(std::move(words)).output);
    return 0;
}

} // namespace livermark::cli
