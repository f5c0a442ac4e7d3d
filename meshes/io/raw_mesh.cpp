#include "meshes/io/raw_mesh.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "core/mesh/neighbours.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

/// Numbers the physical groups that occur, in the order of their tags, and names them.
std::vector<int> number_groups(const std::vector<int> &tags, const std::map<int, std::string> &names,
                               const std::string &word, std::vector<std::string> &group_names) {
    const std::set<int> occurring(tags.begin(), tags.end());
    std::map<int, int> number;
    for (const int tag : occurring) {
        number.emplace(tag, static_cast<int>(group_names.size()));
        const auto named = names.find(tag);
        group_names.push_back(named != names.end() ? named->second
                              : tag == 0           ? "unnamed"
                                                   : fmt::format("{}_{}", word, tag));
    }
    std::vector<int> numbers;
    numbers.reserve(tags.size());
    for (const int tag : tags)
        numbers.push_back(number.at(tag));
    return numbers;
}

/// The patch of each boundary triangle by the triangles of the file.
std::vector<int> boundary_tags(const RawMesh &raw, const core::TetraMesh &mesh, const std::string &file) {
    std::map<std::array<int, 3>, int> tag_of;
    for (std::size_t f = 0; f < raw.triangles.size(); ++f) {
        const auto [entry, is_new] = tag_of.emplace(core::face_key(raw.triangles[f]), raw.patch_tag[f]);
        if (!is_new && entry->second != raw.patch_tag[f])
            throw support::InputError(fmt::format("{}: the triangle of nodes {} {} {} lies in two patches; keep one",
                                                  file, raw.node_tag[raw.triangles[f][0]],
                                                  raw.node_tag[raw.triangles[f][1]],
                                                  raw.node_tag[raw.triangles[f][2]]));
    }
    std::vector<int> tags;
    tags.reserve(mesh.boundary_triangles.size());
    for (const auto &face : mesh.boundary_triangles) {
        const auto named = tag_of.find(core::face_key(face));
        tags.push_back(named == tag_of.end() ? 0 : named->second);
    }
    return tags;
}

} // namespace

void leave_out_stray_triangles(RawMesh &raw) {
    const auto faces = core::sorted_faces(raw.tetrahedra);
    RawMesh kept;
    std::size_t first = raw.triangles.size(), num_stray = 0;
    for (std::size_t t = 0; t < raw.triangles.size(); ++t)
        if (std::ranges::binary_search(faces, core::face_key(raw.triangles[t]), {}, &core::TetrahedronFace::nodes)) {
            kept.triangles.push_back(raw.triangles[t]);
            kept.patch_tag.push_back(raw.patch_tag[t]);
        } else {
            first = std::min(first, t);
            ++num_stray;
        }
    if (num_stray == 0)
        return;
    const auto &[a, b, c] = raw.triangles[first];
    raw.remarks.push_back(
        fmt::format("{} triangles that are not faces of tetrahedra, such as that of nodes {} {} {}, are left out",
                    num_stray, raw.node_tag[a], raw.node_tag[b], raw.node_tag[c]));
    raw.triangles = std::move(kept.triangles);
    raw.patch_tag = std::move(kept.patch_tag);
}

core::TetraMesh assemble_mesh(const RawMesh &raw, const std::string &file) {
    check_nodes(raw, file);
    check_tetrahedra(raw, file);
    check_faces(raw, file);
    core::TetraMesh mesh;
    mesh.points = raw.points;
    mesh.tetrahedra = raw.tetrahedra;
    mesh.region = number_groups(raw.region_tag, raw.region_names, "region", mesh.region_names);
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    mesh.boundary_patch = number_groups(boundary_tags(raw, mesh, file), raw.patch_names, "patch", mesh.patch_names);
    return mesh;
}

} // namespace livermark::meshes
