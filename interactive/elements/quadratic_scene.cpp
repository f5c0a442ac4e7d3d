#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/elements/quadratic_tetrahedra.hpp"

namespace livermark::interactive {

namespace {

constexpr double of_corner = 1.0 / 36.0, of_edge = 4.0 / 27.0;

std::vector<double> volumes_around(const core::TetraMesh &mesh, const std::vector<double> &volumes) {
    std::vector<double> around(mesh.points.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            around[node] += volumes[t];
    return around;
}

std::vector<double> lumped(const core::TetraMesh &mesh, const core::EdgeTable &table,
                           const std::vector<double> &node_mass) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    const auto around = volumes_around(mesh, volumes);
    std::vector<double> masses(mesh.points.size() + table.edges.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        double mass = 0.0;
        for (const int node : mesh.tetrahedra[t])
            mass += node_mass[node] * volumes[t] / around[node];
        for (const int node : mesh.tetrahedra[t])
            masses[node] += of_corner * mass;
        for (const int edge : table.tetrahedron_edge[t])
            masses[mesh.points.size() + edge] += of_edge * mass;
    }
    return masses;
}

/// The middles of edges of boundary triangles whose corners are all constrained.
std::vector<Follower> followers(const Scene &scene, const core::EdgeTable &table) {
    const auto &mesh = scene.body->mesh;
    std::vector<int> place(mesh.points.size(), -1);
    for (std::size_t c = 0; c < scene.constrained_nodes.size(); ++c)
        place[scene.constrained_nodes[c]] = static_cast<int>(c);
    std::map<std::array<int, 2>, int> number;
    for (std::size_t e = 0; e < table.edges.size(); ++e)
        number[table.edges[e]] = static_cast<int>(e);
    std::map<int, Follower> found;
    for (const auto &corners : mesh.boundary_triangles)
        if (std::ranges::all_of(corners, [&](int corner) { return place[corner] >= 0; }))
            for (int a = 0; a < 3; ++a) {
                const int from = corners[a], to = corners[(a + 1) % 3];
                const int node = mesh.num_nodes() + number.at({std::min(from, to), std::max(from, to)});
                found.try_emplace(node, Follower{node, {place[from], place[to]}});
            }
    std::vector<Follower> result;
    for (const auto &[node, follower] : found)
        result.push_back(follower);
    return result;
}

} // namespace

Scene quadratic_scene(Scene scene) {
    const auto &mesh = scene.body->mesh;
    const auto table = core::edge_table(mesh.tetrahedra);
    scene.node_mass = lumped(mesh, table, scene.node_mass);
    scene.followers = followers(scene, table);
    for (const auto &[a, b] : table.edges)
        scene.own_nodes.emplace_back(0.5 * (mesh.points[a] + mesh.points[b]));
    return scene;
}

} // namespace livermark::interactive
