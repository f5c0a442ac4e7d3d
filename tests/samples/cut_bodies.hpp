#pragma once

#include <random>
#include <set>
#include <vector>

#include "core/problem.hpp"
#include "tests/samples/test_meshes.hpp"

/// Bodies from which tetrahedra are taken away.
namespace livermark::tests {

/// A box of two materials, its nodes moved at random.
inline core::Body crooked_box(const core::Vector3 &size, const std::array<int, 3> &bricks) {
    core::Body body{.name = "box", .mesh = box_mesh(size, bricks), .materials = {}};
    auto &mesh = body.mesh;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> part(-0.0012, 0.0012);
    for (auto &point : mesh.points)
        point += core::Vector3(part(random), part(random), part(random));
    mesh.region_names = {"soft", "hard"};
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        mesh.region[t] = mesh.points[mesh.tetrahedra[t][0]].x() < 0.04 ? 0 : 1;
    body.materials = {{1060.0, 5e3, 0.4}, {1100.0, 2e4, 0.45}};
    return body;
}

inline std::vector<int> tetrahedra_near(const core::Body &body, const core::Vector3 &place, double distance) {
    std::vector<int> near;
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t) {
        core::Vector3 middle = core::Vector3::Zero();
        for (const int node : body.mesh.tetrahedra[t])
            middle += 0.25 * body.mesh.points[node];
        if ((middle - place).norm() < distance)
            near.push_back(t);
    }
    return near;
}

/// A body without some of its tetrahedra, and without nodes that are in none.
struct Rest {
    core::Body body;
    std::vector<int> number; ///< of each node before, -1 where it is gone
};

inline Rest without(const core::Body &body, const std::set<int> &removed) {
    Rest rest{body, std::vector<int>(body.mesh.points.size(), -1)};
    auto &mesh = rest.body.mesh;
    mesh.tetrahedra.clear();
    mesh.region.clear();
    mesh.points.clear();
    mesh.boundary_triangles.clear();
    mesh.boundary_patch.clear();
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        if (!removed.contains(t)) {
            mesh.tetrahedra.push_back(body.mesh.tetrahedra[t]);
            mesh.region.push_back(body.mesh.region[t]);
            for (const int node : body.mesh.tetrahedra[t])
                rest.number[node] = 0;
        }
    for (std::size_t i = 0; i < rest.number.size(); ++i)
        if (rest.number[i] == 0) {
            rest.number[i] = mesh.num_nodes();
            mesh.points.push_back(body.mesh.points[i]);
        }
    for (auto &nodes : mesh.tetrahedra)
        for (int &node : nodes)
            node = rest.number[node];
    return rest;
}

} // namespace livermark::tests
