#include "core/mesh/tetra_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

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
    const auto key_of = [](std::array<int, 3> face) {
        std::ranges::sort(face);
        return face;
    };
    std::map<std::array<int, 3>, int> num_owners;
    std::vector<std::array<int, 3>> faces;
    faces.reserve(4 * tetrahedra.size());
    for (const auto &nodes : tetrahedra)
        for (const auto &[a, b, c] : tetrahedron_faces)
            ++num_owners[key_of(faces.emplace_back(std::array{nodes[a], nodes[b], nodes[c]}))];
    std::erase_if(faces, [&](const auto &face) { return num_owners.at(key_of(face)) > 1; });
    return faces;
}

Vector3 area_vector(const TetraMesh &mesh, int triangle) {
    const auto &[a, b, c] = mesh.boundary_triangles[triangle];
    return 0.5 * (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
}

EdgeTable edge_table(std::span<const std::array<int, 4>> tetrahedra) {
    const auto edge_of = [](const std::array<int, 4> &nodes, const std::array<int, 2> &local) {
        return std::array{std::min(nodes[local[0]], nodes[local[1]]), std::max(nodes[local[0]], nodes[local[1]])};
    };
    EdgeTable table;
    table.edges.reserve(6 * tetrahedra.size());
    for (const auto &nodes : tetrahedra)
        for (const auto &local : tetrahedron_edges)
            table.edges.push_back(edge_of(nodes, local));
    std::ranges::sort(table.edges);
    table.edges.erase(std::unique(table.edges.begin(), table.edges.end()), table.edges.end());

    table.tetrahedron_edge.reserve(tetrahedra.size());
    for (const auto &nodes : tetrahedra) {
        auto &found = table.tetrahedron_edge.emplace_back();
        for (std::size_t e = 0; e < 6; ++e)
            found[e] = static_cast<int>(std::ranges::lower_bound(table.edges, edge_of(nodes, tetrahedron_edges[e])) -
                                        table.edges.begin());
    }
    return table;
}

} // namespace livermark::core
