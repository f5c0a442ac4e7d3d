#include "meshes/io/mesh_checks.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <utility>

#include "core/mesh/neighbours.hpp"
#include "core/mesh/overlaps.hpp"
#include "core/mesh/plausible_liver.hpp"
#include "meshes/cutting/cut.hpp"
#include "meshes/io/mesh_figures.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

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
            name != raw.patch_names.end() && name->second == wound_patch)
            for (const int node : raw.triangles[f])
                is_in_wound[node] = true;
    return is_in_wound;
}

void refuse_coinciding_nodes(const RawMesh &raw, const std::string &file) {
    const auto is_in_wound = nodes_of_wound(raw);
    if (const auto two =
            core::nodes_in_one_place(raw.points, [&](int a, int b) { return is_in_wound[a] && is_in_wound[b]; }))
        throw support::InputError(fmt::format("{}: {} and {} have the same coordinates; merge them", file,
                                              node_name(raw, two->first), node_name(raw, two->second)));
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
            throw support::InputError(fmt::format("{}: {} and {} are in parts that do not touch; keep one part", file,
                                                  node_name(raw, 0), node_name(raw, static_cast<int>(node))));
    if (const auto apart = core::apart_by_faces(raw.tetrahedra))
        throw support::InputError(fmt::format("{}: tetrahedra {} and {} are in parts that share only an edge or a "
                                              "node; join them by faces, or keep one part",
                                              file, raw.tetrahedron_tag[apart->first],
                                              raw.tetrahedron_tag[apart->second]));
}

} // namespace

void check_nodes(const RawMesh &raw, const std::string &file) {
    std::vector<bool> used(raw.points.size(), false);
    for (const auto &nodes : raw.tetrahedra)
        for (const int node : nodes)
            used[node] = true;
    for (int node = 0; node < static_cast<int>(raw.points.size()); ++node) {
        if (!raw.points[node].allFinite())
            throw support::InputError(
                fmt::format("{}: {} has a coordinate that is not finite; correct it", file, node_name(raw, node)));
        if (!used[node] && !raw.tetrahedra.empty())
            throw support::InputError(
                fmt::format("{}: {} belongs to no tetrahedron; remove it", file, node_name(raw, node)));
    }
    if (!raw.points.empty())
        refuse_coinciding_nodes(raw, file);
}

void check_tetrahedra(const RawMesh &raw, const std::string &file) {
    if (raw.tetrahedra.empty())
        throw support::InputError(
            fmt::format("{}: there are no tetrahedra; mesh the volume, not only the surface", file));
    // A tetrahedron this flat has no stiffness or time step that a double can hold.
    constexpr double flat = 1e-9;
    for (std::size_t t = 0; t < raw.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = raw.tetrahedra[t];
        const auto &x = raw.points;
        const double quality = tetrahedron_quality(x[a], x[b], x[c], x[d]);
        if (!(quality > flat))
            throw support::InputError(fmt::format("{}: tetrahedron {} {}; {}", file, raw.tetrahedron_tag[t],
                                                  quality < -flat ? "is inverted" : "is flat",
                                                  quality < -flat ? "exchange two of its nodes" : "remesh there"));
    }
    if (const auto two = core::tetrahedra_of_same_nodes(raw.tetrahedra))
        throw support::InputError(fmt::format("{}: tetrahedra {} and {} have the same nodes; remove one", file,
                                              raw.tetrahedron_tag[two->first], raw.tetrahedron_tag[two->second]));
}

void check_faces(const RawMesh &raw, const std::string &file) {
    const auto faces = core::sorted_faces(raw.tetrahedra);
    if (const auto face = core::face_of_too_many(faces))
        throw support::InputError(fmt::format("{}: more than two tetrahedra share the face of nodes {}; remesh without "
                                              "overlaps",
                                              file, corner_names(raw, *face)));
    for (const auto &triangle : raw.triangles)
        if (!std::ranges::binary_search(faces, core::face_key(triangle), {}, &core::TetrahedronFace::nodes))
            throw support::InputError(
                fmt::format("{}: the triangle of nodes {} is not a face of a tetrahedron; remove it", file,
                            corner_names(raw, triangle)));
    refuse_several_parts(raw, file);
}

} // namespace livermark::meshes
