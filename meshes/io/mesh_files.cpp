#include "meshes/io/mesh_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <string_view>
#include <system_error>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"

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

namespace {

namespace fs = std::filesystem;

/// Longest side of an organ's bounding box, in each of support::length_units.
constexpr std::array<double, support::length_units.size()> longest_organ{core::largest_organ, 60.0, 2000.0};

bool is_ascii_msh(const fs::path &file) {
    if (support::file_ending(file) != ".msh")
        return false;
    // Comments may come before the format. A file that is damaged here is for the reader of ASCII files, which says
    // where.
    std::string start(4096, '\0'), version, is_binary;
    std::ifstream stream(file, std::ios::binary);
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    const auto format = start.find("$MeshFormat");
    if (format == std::string::npos)
        return true;
    std::istringstream words(start.substr(format));
    words >> version >> version >> is_binary;
    return is_binary != "1";
}

core::TetraMesh read_converted(const fs::path &file, std::vector<std::string> &remarks) {
    const auto converted = support::convert_by_script(
        "convert_mesh", file,
        "save it as ASCII MSH, VTU, VTK or INP with tetrahedra, and check that python3-meshio is installed");
    remarks.insert(remarks.end(), converted.remarks.begin(), converted.remarks.end());
    return parse_msh(converted.text, file.string(), &remarks);
}

/// Files that come from a segmentation and never hold tetrahedra.
void refuse_segmentation(const fs::path &file) {
    constexpr std::array<std::string_view, 7> images{".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".dcm"};
    const auto name = support::lower_case(file.filename().string());
    const auto ends_so = [&](std::string_view ending) { return name.ends_with(ending); };
    const bool is_image = std::ranges::any_of(images, ends_so);
    if (is_image || has_surface_ending(file))
        throw support::InputError(
            "{}: this is {}, not a mesh of tetrahedra; make a body of it with `livermark mesh {} {} -o body.msh`",
            file.string(), is_image ? "an image" : "a surface", is_image ? "--labels" : "--surfaces",
            file.filename().string());
}

} // namespace

core::TetraMesh read_mesh(const fs::path &file, std::vector<std::string> &remarks) {
    support::check_readable(file);
    refuse_segmentation(file);
    return is_ascii_msh(file) ? read_msh(file, &remarks) : read_converted(file, remarks);
}

UnitGuess guess_unit(const std::vector<core::Vector3> &points, double volume, const std::string &file) {
    const double longest = core::bounding_box(points).sizes().maxCoeff();
    const auto unit =
        static_cast<std::size_t>(std::ranges::lower_bound(longest_organ, longest) - longest_organ.begin());
    if (!(longest > 0.0) || unit == longest_organ.size())
        throw support::InputError(
            "{}: its longest side is {:g}, which fits no organ in m, cm or mm; set 'unit' in a body .toml", file,
            longest);
    const auto &[name, metres] = support::length_units[unit];
    const double litres = 1e3 * volume * metres * metres * metres;
    UnitGuess guess{std::string(name), metres, {}};
    const auto by_length = fmt::format("from its longest side, which is then {:.3g} cm", 1e2 * longest * metres);
    if (litres >= core::smallest_liver && litres <= core::largest_liver)
        guess.remark = fmt::format("{}, and its volume, which is then {:.3g} L", by_length, litres);
    else
        guess.remark = fmt::format(
            "{}; but its volume is then {:.2g} L, where an adult liver has {} to {} L, and a unit of {:.2g} m "
            "would make it {} L",
            by_length, litres, core::smallest_liver, core::largest_liver, std::cbrt(1e-3 * core::usual_liver / volume),
            core::usual_liver);
    return guess;
}

namespace {

using Text = fmt::memory_buffer;

template <typename... Arguments>
void print(Text &text, fmt::format_string<Arguments...> format, Arguments &&...arguments) {
    fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

void print_names(Text &text, const core::TetraMesh &mesh) {
    print(text, "$PhysicalNames\n{}\n", mesh.patch_names.size() + mesh.region_names.size());
    for (std::size_t p = 0; p < mesh.patch_names.size(); ++p)
        print(text, "2 {} \"{}\"\n", p + 1, mesh.patch_names[p]);
    for (std::size_t r = 0; r < mesh.region_names.size(); ++r)
        print(text, "3 {} \"{}\"\n", r + 1, mesh.region_names[r]);
    print(text, "$EndPhysicalNames\n");
}

/// One geometric entity per group. None has a boundary of its own: the mesh alone says what touches what.
void print_entities(Text &text, const core::TetraMesh &mesh) {
    const auto box = core::bounding_box(mesh.points);
    const auto &low = box.min(), &high = box.max();
    print(text, "$Entities\n0 0 {} {}\n", mesh.patch_names.size(), mesh.region_names.size());
    for (const std::size_t count : {mesh.patch_names.size(), mesh.region_names.size()})
        for (std::size_t tag = 1; tag <= count; ++tag)
            print(text, "{} {} {} {} {} {} {} 1 {} 0\n", tag, low.x(), low.y(), low.z(), high.x(), high.y(), high.z(),
                  tag);
    print(text, "$EndEntities\n");
}

void print_nodes(Text &text, const core::TetraMesh &mesh) {
    print(text, "$Nodes\n1 {0} 1 {0}\n3 1 0 {0}\n", mesh.num_nodes());
    for (int node = 1; node <= mesh.num_nodes(); ++node)
        print(text, "{}\n", node);
    for (const auto &point : mesh.points)
        print(text, "{} {} {}\n", point.x(), point.y(), point.z());
    print(text, "$EndNodes\n");
}

/// The elements of each group as a block, numbered on from `tag`.
template <std::size_t num_corners>
void print_blocks(Text &text, int dimension, int element_type,
                  const std::vector<std::array<int, num_corners>> &elements, std::span<const int> group,
                  std::size_t num_groups, std::size_t &tag) {
    for (std::size_t g = 0; g < num_groups; ++g) {
        print(text, "{} {} {} {}\n", dimension, g + 1, element_type, std::ranges::count(group, static_cast<int>(g)));
        for (std::size_t e = 0; e < elements.size(); ++e) {
            if (group[e] != static_cast<int>(g))
                continue;
            print(text, "{}", tag++);
            for (const int node : elements[e])
                print(text, " {}", node + 1);
            print(text, "\n");
        }
    }
}

void print_elements(Text &text, const core::TetraMesh &mesh) {
    constexpr int msh_triangle = 2;
    constexpr int msh_tetrahedron = 4;
    print(text, "$Elements\n{0} {1} 1 {1}\n", mesh.patch_names.size() + mesh.region_names.size(),
          mesh.boundary_triangles.size() + mesh.tetrahedra.size());
    std::size_t tag = 1;
    print_blocks(text, 2, msh_triangle, mesh.boundary_triangles, mesh.boundary_patch, mesh.patch_names.size(), tag);
    print_blocks(text, 3, msh_tetrahedron, mesh.tetrahedra, mesh.region, mesh.region_names.size(), tag);
    print(text, "$EndElements\n");
}

} // namespace

void check_name_of_mesh(const std::filesystem::path &mesh_file) {
    if (mesh_file.extension() != ".msh")
        throw support::InputError("{}: the mesh is written as MSH; end its name in .msh", mesh_file.string());
}

void write_msh(const std::filesystem::path &file, const core::TetraMesh &mesh) {
    Text text;
    print(text, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    print_names(text, mesh);
    print_entities(text, mesh);
    print_nodes(text, mesh);
    print_elements(text, mesh);

    support::write_whole(file, {text.data(), text.size()});
}

} // namespace livermark::meshes
