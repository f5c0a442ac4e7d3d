#include "meshes/io/mesh_checks.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

double tetrahedron_quality(const core::Vector3 &a, const core::Vector3 &b, const core::Vector3 &c,
                           const core::Vector3 &d) {
    const double mean_square = ((b - a).squaredNorm() + (c - a).squaredNorm() + (d - a).squaredNorm() +
                                (c - b).squaredNorm() + (d - b).squaredNorm() + (d - c).squaredNorm()) /
                               6.0;
    return 6.0 * std::numbers::sqrt2 * core::signed_volume(a, b, c, d) / (mean_square * std::sqrt(mean_square));
}

MeshFigures mesh_figures(const core::TetraMesh &mesh) {
    MeshFigures figures;
    figures.num_tetrahedra = mesh.num_tetrahedra();
    figures.num_nodes = mesh.num_nodes();
    figures.smallest_quality = std::numeric_limits<double>::infinity();
    for (const auto &[a, b, c, d] : mesh.tetrahedra) {
        const auto &x = mesh.points;
        figures.volume += core::signed_volume(x[a], x[b], x[c], x[d]);
        figures.smallest_quality = std::min(figures.smallest_quality, tetrahedron_quality(x[a], x[b], x[c], x[d]));
    }
    figures.extent = core::bounding_box(mesh.points).sizes();

    const auto edges = core::edge_table(mesh.tetrahedra).edges;
    figures.num_edges = static_cast<int>(edges.size());
    figures.shortest_edge = std::numeric_limits<double>::infinity();
    for (const auto &[i, j] : edges) {
        const double length = (mesh.points[j] - mesh.points[i]).norm();
        figures.mean_edge += length / static_cast<double>(edges.size());
        figures.shortest_edge = std::min(figures.shortest_edge, length);
    }
    return figures;
}

std::vector<int> keep_used_groups(std::vector<int> &groups, std::vector<std::string> &names) {
    const std::set<int> used(groups.begin(), groups.end());
    std::vector<std::string> kept;
    std::map<int, int> number;
    for (const int group : used) {
        number[group] = static_cast<int>(kept.size());
        kept.push_back(names[group]);
    }
    for (int &group : groups)
        group = number.at(group);
    names = std::move(kept);
    return {used.begin(), used.end()};
}

std::string to_text(const MeshFigures &figures) {
    return fmt::format("tetrahedra        {}\n"
                       "nodes             {}\n"
                       "edges             {}\n"
                       "volume            {:.1f} mL\n"
                       "extent            {:.1f} x {:.1f} x {:.1f} mm\n"
                       "mean edge         {:.2f} mm\n"
                       "shortest edge     {:.2f} mm ({:.3f} of the mean)\n"
                       "smallest quality  {:.3f}\n",
                       figures.num_tetrahedra, figures.num_nodes, figures.num_edges, 1e6 * figures.volume,
                       1e3 * figures.extent.x(), 1e3 * figures.extent.y(), 1e3 * figures.extent.z(),
                       1e3 * figures.mean_edge, 1e3 * figures.shortest_edge, figures.shortest_edge / figures.mean_edge,
                       figures.smallest_quality);
}

namespace {

std::string node_name(const RawMesh &raw, int node) {
    return fmt::format("node {}", raw.node_tag[node]);
}

std::string corner_names(const RawMesh &raw, const std::array<int, 3> &face) {
    return fmt::format("{} {} {}", raw.node_tag[face[0]], raw.node_tag[face[1]], raw.node_tag[face[2]]);
}

/// (N) whether a node is in the patch that a cut leaves.
std::vector<bool> nodes_of_wound(const RawMesh &raw) {
    std::vector<bool> is_in_wound(raw.points.size(), false);
    for (std::size_t f = 0; f < raw.triangles.size(); ++f)
        if (const auto name = raw.patch_names.find(raw.patch_tag[f]);
            name != raw.patch_names.end() && name->second == core::wound_patch)
            for (const int node : raw.triangles[f])
                is_in_wound[node] = true;
    return is_in_wound;
}

void refuse_coinciding_nodes(const RawMesh &raw, const std::string &file) {
    const auto is_in_wound = nodes_of_wound(raw);
    if (const auto two =
            core::nodes_in_one_place(raw.points, [&](int a, int b) { return is_in_wound[a] && is_in_wound[b]; }))
        throw support::InputError("{}: {} and {} have the same coordinates; merge them", file,
                                  node_name(raw, two->first), node_name(raw, two->second));
}

/// Union-find over the nodes, with path halving.
int root_of(std::vector<int> &parent, int node) {
    while (parent[node] != node)
        node = parent[node] = parent[parent[node]];
    return node;
}

/// A part that hangs on an edge or a node swings about it: finite elements have no reference for it.
void refuse_several_parts(const RawMesh &raw, const std::string &file) {
    std::vector<int> parent(raw.points.size());
    std::iota(parent.begin(), parent.end(), 0);
    for (const auto &nodes : raw.tetrahedra)
        for (const int node : nodes)
            parent[root_of(parent, node)] = root_of(parent, nodes[0]);
    for (std::size_t node = 1; node < parent.size(); ++node)
        if (root_of(parent, static_cast<int>(node)) != root_of(parent, 0))
            throw support::InputError("{}: {} and {} are in parts that do not touch; keep one part", file,
                                      node_name(raw, 0), node_name(raw, static_cast<int>(node)));
    if (const auto apart = core::apart_by_faces(raw.tetrahedra))
        throw support::InputError("{}: tetrahedra {} and {} are in parts that share only an edge or a node; join them "
                                  "by faces, or keep one part",
                                  file, raw.tetrahedron_tag[apart->first], raw.tetrahedron_tag[apart->second]);
}

} // namespace

void check_nodes(const RawMesh &raw, const std::string &file) {
    std::vector<bool> used(raw.points.size(), false);
    for (const auto &nodes : raw.tetrahedra)
        for (const int node : nodes)
            used[node] = true;
    for (int node = 0; node < static_cast<int>(raw.points.size()); ++node) {
        if (!raw.points[node].allFinite())
            throw support::InputError("{}: {} has a coordinate that is not finite; correct it", file,
                                      node_name(raw, node));
        if (!used[node] && !raw.tetrahedra.empty())
            throw support::InputError("{}: {} belongs to no tetrahedron; remove it", file, node_name(raw, node));
    }
    if (!raw.points.empty())
        refuse_coinciding_nodes(raw, file);
}

void check_tetrahedra(const RawMesh &raw, const std::string &file) {
    if (raw.tetrahedra.empty())
        throw support::InputError("{}: there are no tetrahedra; mesh the volume, not only the surface", file);
    // A tetrahedron this flat has no stiffness or time step that a double can hold.
    constexpr double flat = 1e-9;
    for (std::size_t t = 0; t < raw.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = raw.tetrahedra[t];
        const auto &x = raw.points;
        const double quality = tetrahedron_quality(x[a], x[b], x[c], x[d]);
        if (!(quality > flat))
            throw support::InputError("{}: tetrahedron {} {}; {}", file, raw.tetrahedron_tag[t],
                                      quality < -flat ? "is inverted" : "is flat",
                                      quality < -flat ? "exchange two of its nodes" : "remesh there");
    }
    if (const auto two = core::tetrahedra_of_same_nodes(raw.tetrahedra))
        throw support::InputError("{}: tetrahedra {} and {} have the same nodes; remove one", file,
                                  raw.tetrahedron_tag[two->first], raw.tetrahedron_tag[two->second]);
}

void check_faces(const RawMesh &raw, const std::string &file) {
    const auto faces = core::sorted_faces(raw.tetrahedra);
    if (const auto face = core::face_of_too_many(faces))
        throw support::InputError("{}: more than two tetrahedra share the face of nodes {}; remesh without overlaps",
                                  file, corner_names(raw, *face));
    for (const auto &triangle : raw.triangles)
        if (!std::ranges::binary_search(faces, core::face_key(triangle), {}, &core::TetrahedronFace::nodes))
            throw support::InputError("{}: the triangle of nodes {} is not a face of a tetrahedron; remove it", file,
                                      corner_names(raw, triangle));
    refuse_several_parts(raw, file);
}

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
            throw support::InputError("{}: the triangle of nodes {} {} {} lies in two patches; keep one", file,
                                      raw.node_tag[raw.triangles[f][0]], raw.node_tag[raw.triangles[f][1]],
                                      raw.node_tag[raw.triangles[f][2]]);
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
