#include "core/mesh/tetra_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "core/mesh/neighbours.hpp"

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

} // namespace livermark::core
