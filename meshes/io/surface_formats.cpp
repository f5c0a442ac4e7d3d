#include "meshes/io/surface_formats.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "support/file_ending.hpp"

namespace livermark::meshes {

namespace {

constexpr std::array<std::string_view, 4> surface_endings{".stl", ".obj", ".ply", ".off"};

} // namespace

bool has_surface_ending(const std::filesystem::path &file) {
    return std::ranges::find(surface_endings, support::file_ending(file)) != surface_endings.end();
}

bool is_surface_file(const std::filesystem::path &file) {
    const auto ending = support::file_ending(file);
    if (has_surface_ending(file) || ending == ".vtp")
        return true;
    return ending == ".vtk" && first_bytes(file).find("POLYDATA") != std::string::npos;
}

std::string first_bytes(const std::filesystem::path &file) {
    if (std::error_code error; !std::filesystem::is_regular_file(file, error))
        return {};
    std::string bytes(1000, '\0');
    std::ifstream stream(file, std::ios::binary);
    stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(stream.gcount()));
    return bytes;
}

} // namespace livermark::meshes
