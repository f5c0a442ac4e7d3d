#include "meshes/io/msh_writer.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <span>

#include "core/mesh/bounding_box.hpp"
#include "support/whole_file.hpp"

namespace livermark::meshes {

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
