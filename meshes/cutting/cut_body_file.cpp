#include "meshes/cutting/cut_body_file.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <sstream>
#include <toml++/toml.h>

#include "meshes/anatomy/body_axes.hpp"
#include "meshes/io/msh_writer.hpp"
#include "support/whole_file.hpp"

namespace livermark::meshes {

namespace {

std::string quoted(const std::string &text) {
    std::ostringstream out;
    out << toml::value<std::string>(text);
    return out.str();
}

std::string key(const std::string &name) {
    const bool is_bare = std::ranges::all_of(
        name, [](unsigned char c) { return c < 0x80 && (std::isalnum(c) != 0 || c == '_' || c == '-'); });
    return is_bare && !name.empty() ? name : quoted(name);
}

std::filesystem::path write_body(std::filesystem::path mesh_file, const core::Body &body, const std::string &title,
                                 const std::string &command) {
    auto text = fmt::format("title = {}\nmesh = {}\ngenerator = {}\n", quoted(title),
                            quoted(mesh_file.filename().string()), quoted(command)) +
                axes_toml(body.axes);
    for (std::size_t region = 0; region < body.materials.size(); ++region) {
        const auto &material = body.materials[region];
        text += fmt::format("\n[regions.{}]\ndensity = {} # kg/m^3\nyoung_modulus = {} # Pa\npoisson_ratio = {}\n"
                            "source = {}\n",
                            key(body.mesh.region_names[region]), material.density, material.young_modulus,
                            material.poisson_ratio, quoted(fmt::format("as of {}, which was cut", body.name)));
    }
    write_msh(mesh_file, body.mesh);
    auto body_file = mesh_file.replace_extension(".toml");
    support::write_whole(body_file, text);
    return body_file;
}

} // namespace

void check_name_of_mesh(const std::filesystem::path &mesh_file) {
    if (mesh_file.extension() != ".msh")
        throw support::InputError(
            fmt::format("{}: the mesh is written as MSH; end its name in .msh", mesh_file.string()));
}

std::vector<std::filesystem::path> write_cut_body(const std::filesystem::path &mesh_file, const CutBody &cut,
                                                  const std::string &command) {
    check_name_of_mesh(mesh_file);
    std::vector<std::filesystem::path> files{
        write_body(mesh_file, cut.body, fmt::format("{}, cut", cut.body.name), command)};
    for (std::size_t piece = 0; piece < cut.small_pieces.size(); ++piece) {
        auto file = mesh_file;
        file.replace_filename(fmt::format("{}_piece_{}.msh", mesh_file.stem().string(), piece + 2));
        files.push_back(write_body(file, cut.small_pieces[piece],
                                   fmt::format("A piece that was cut off from {}", cut.body.name), command));
    }
    return files;
}

} // namespace livermark::meshes
