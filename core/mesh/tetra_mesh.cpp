#include "core/mesh/tetra_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace livermark::core {

double signed_volume(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d) {
    return (b - a).cross(c - a).dot(d - a) / 6.0;
}

std::vector<double> tetrahedron_volumes(const TetraMesh &mesh) {
    std::vector<double> volumes;
    volumes.reserve(mesh.tetrahedra.size());
    for (const auto &[a, b, c, d] : mesh.tetrahedra)
        volumes.push_back(signed_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]));
    return volumes;
}

std::vector<double> nodal_volumes(const TetraMesh &mesh) {
    const auto volumes = tetrahedron_volumes(mesh);
    std::vector<double> nodal(mesh.points.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            nodal[node] += volumes[t] / 4.0;
    return nodal;
}

std::vector<std::array<int, 3>> outer_faces(std::span<const std::array<int, 4>> tetrahedra) {
    const auto neighbours = face_neighbours(tetrahedra);
    std::vector<std::array<int, 3>> faces;
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (neighbours[t][k] < 0) {
                const auto &[a, b, c] = tetrahedron_faces[k];
                faces.push_back({tetrahedra[t][a], tetrahedra[t][b], tetrahedra[t][c]});
            }
    return faces;
}

Vector3 area_vector(const TetraMesh &mesh, int triangle) {
    const auto &[a, b, c] = mesh.boundary_triangles[triangle];
    return 0.5 * (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
}

EdgeTable edge_table(std::span<const std::array<int, 4>> tetrahedra) {
    // Edges of tetrahedra with their numbers: sorted by the higher end, then by the lower one.
    struct Use {
        int low, high, number;
    };
    std::vector<Use> uses;
    uses.reserve(6 * tetrahedra.size());
    int num_nodes = 0;
    for (const auto &nodes : tetrahedra)
        for (const auto &[a, b] : tetrahedron_edges) {
            const auto [low, high] = std::minmax(nodes[a], nodes[b]);
            num_nodes = std::max(num_nodes, high + 1);
            uses.push_back({low, high, static_cast<int>(uses.size())});
        }
    std::vector<Use> sorted(uses.size());
    const auto sort_by = [&](int Use::*end) {
        std::vector<int> start(static_cast<std::size_t>(num_nodes) + 1, 0);
        for (const auto &use : uses)
            ++start[use.*end + 1];
        for (std::size_t i = 1; i < start.size(); ++i)
            start[i] += start[i - 1];
        for (const auto &use : uses)
            sorted[start[use.*end]++] = use;
        uses.swap(sorted);
    };
    sort_by(&Use::high);
    sort_by(&Use::low);
    EdgeTable table;
    table.tetrahedron_edge.resize(tetrahedra.size());
    for (const auto &[low, high, number] : uses) {
        if (table.edges.empty() || table.edges.back() != std::array{low, high})
            table.edges.push_back({low, high});
        table.tetrahedron_edge[number / 6][number % 6] = static_cast<int>(table.edges.size()) - 1;
    }
    return table;
}

std::array<int, 3> face_key(std::array<int, 3> nodes) {
    std::ranges::sort(nodes);
    return nodes;
}

std::array<int, 3> face_key(const std::array<int, 4> &tetrahedron, std::size_t face) {
    const auto &[a, b, c] = tetrahedron_faces[face];
    return face_key({tetrahedron[a], tetrahedron[b], tetrahedron[c]});
}

std::vector<TetrahedronFace> sorted_faces(std::span<const std::array<int, 4>> tetrahedra) {
    std::vector<TetrahedronFace> faces;
    faces.reserve(4 * tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            faces.push_back({face_key(tetrahedra[t], k), static_cast<int>(t), static_cast<int>(k)});
    std::ranges::sort(faces);
    return faces;
}

std::optional<std::array<int, 3>> face_of_too_many(std::span<const TetrahedronFace> sorted) {
    for (std::size_t f = 2; f < sorted.size(); ++f)
        if (sorted[f].nodes == sorted[f - 2].nodes)
            return sorted[f].nodes;
    return std::nullopt;
}

std::vector<std::array<int, 4>> face_neighbours(std::span<const std::array<int, 4>> tetrahedra) {
    const auto faces = sorted_faces(tetrahedra);
    std::vector<std::array<int, 4>> neighbours(tetrahedra.size(), {-1, -1, -1, -1});
    for (std::size_t f = 1; f < faces.size(); ++f)
        if (const auto &one = faces[f - 1], &other = faces[f]; one.nodes == other.nodes) {
            neighbours[one.tetrahedron][one.face] = other.tetrahedron;
            neighbours[other.tetrahedron][other.face] = one.tetrahedron;
        }
    return neighbours;
}

std::vector<std::vector<int>> tetrahedra_at_nodes(const TetraMesh &mesh) {
    std::vector<std::vector<int>> stars(mesh.points.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            stars[node].push_back(static_cast<int>(t));
    return stars;
}

namespace {

template <class Visit> void for_each_part(std::string_view name, const Visit &visit) {
    for (std::size_t begin = 0; begin <= name.size();) {
        const auto end = std::min(name.find(patch_joint, begin), name.size());
        visit(name.substr(begin, end - begin));
        begin = end + 1;
    }
}

} // namespace

bool is_in_patch(std::string_view name_of_facet, std::string_view patch) {
    bool is_in = name_of_facet == patch;
    for_each_part(name_of_facet, [&](std::string_view part) { is_in = is_in || part == patch; });
    return is_in;
}

std::vector<std::string> patches_of(const TetraMesh &mesh) {
    std::vector<std::string> patches;
    for (const auto &name : mesh.patch_names)
        for_each_part(name, [&](std::string_view part) {
            if (std::ranges::find(patches, part) == patches.end())
                patches.emplace_back(part);
        });
    return patches;
}

std::vector<int> facets_in_patch(const TetraMesh &mesh, std::string_view patch) {
    std::vector<bool> is_in;
    for (const auto &name : mesh.patch_names)
        is_in.push_back(is_in_patch(name, patch));
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (is_in[static_cast<std::size_t>(mesh.boundary_patch[f])])
            facets.push_back(f);
    return facets;
}

std::vector<int> parts_by_faces(std::span<const std::array<int, 4>> tetrahedra,
                                const std::function<bool(int, int)> &are_joined) {
    std::vector<int> parent(tetrahedra.size()); // union-find, with path halving
    std::iota(parent.begin(), parent.end(), 0);
    const auto root_of = [&](int t) {
        while (parent[t] != t)
            t = parent[t] = parent[parent[t]];
        return t;
    };
    const auto faces = sorted_faces(tetrahedra);
    for (std::size_t first = 0, other = 1; other < faces.size(); ++other)
        if (faces[other].nodes != faces[first].nodes)
            first = other;
        else if (!are_joined || are_joined(faces[first].tetrahedron, faces[other].tetrahedron))
            parent[root_of(faces[first].tetrahedron)] = root_of(faces[other].tetrahedron);
    std::vector<int> part(tetrahedra.size()), number(tetrahedra.size(), -1);
    int num_parts = 0;
    for (int t = 0; t < static_cast<int>(tetrahedra.size()); ++t) {
        int &root_number = number[root_of(t)];
        if (root_number < 0)
            root_number = num_parts++;
        part[t] = root_number;
    }
    return part;
}

std::optional<std::pair<int, int>> nodes_in_one_place(std::span<const Vector3> points,
                                                      const std::function<bool(int, int)> &is_meant) {
    if (points.empty())
        return std::nullopt;
    const double tolerance = 1e-9 * extent(points);
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](int node) { return std::pair(points[node].x(), node); });
    for (std::size_t a = 0; a < order.size(); ++a)
        for (std::size_t b = a + 1; b < order.size(); ++b) {
            const Vector3 apart = points[order[b]] - points[order[a]];
            if (apart.x() > tolerance)
                break;
            if (apart.norm() <= tolerance && !(is_meant && is_meant(order[a], order[b])))
                return std::pair(order[a], order[b]);
        }
    return std::nullopt;
}

std::optional<std::pair<int, int>> tetrahedra_of_same_nodes(std::span<const std::array<int, 4>> tetrahedra) {
    std::vector<std::pair<std::array<int, 4>, int>> sorted; // nodes ascending, and the tetrahedron
    sorted.reserve(tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
        sorted.emplace_back(tetrahedra[t], static_cast<int>(t));
        std::ranges::sort(sorted.back().first);
    }
    std::ranges::sort(sorted);
    std::optional<std::pair<int, int>> two;
    for (std::size_t k = 1; k < sorted.size(); ++k) {
        const bool is_second =
            sorted[k].first == sorted[k - 1].first && (k == 1 || sorted[k].first != sorted[k - 2].first);
        if (is_second && (!two || sorted[k].second < two->second))
            two.emplace(sorted[k - 1].second, sorted[k].second);
    }
    return two;
}

} // namespace livermark::core
