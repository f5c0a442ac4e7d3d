#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "msm/cutting/cut_parts.hpp"
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

/// Tetrahedron of each boundary triangle.
inline std::vector<int> tetrahedra_of_facets(const core::TetraMesh &mesh) {
    const auto faces = core::sorted_faces(mesh.tetrahedra);
    std::vector<int> owners;
    for (const auto &triangle : mesh.boundary_triangles)
        owners.push_back(
            std::ranges::lower_bound(faces, core::face_key(triangle), {}, &core::TetrahedronFace::nodes)->tetrahedron);
    return owners;
}

/// A body without some of its tetrahedra, and without nodes that are in none. What a cut opens is no boundary triangle.
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
    rest.body.modulus_factor.clear();
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        if (!removed.contains(t)) {
            if (!body.modulus_factor.empty())
                rest.body.modulus_factor.push_back(body.modulus_factor[t]);
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
    const auto owners = tetrahedra_of_facets(body.mesh);
    for (std::size_t f = 0; f < owners.size(); ++f)
        if (!removed.contains(owners[f])) {
            mesh.boundary_triangles.push_back(body.mesh.boundary_triangles[f]);
            mesh.boundary_patch.push_back(body.mesh.boundary_patch[f]);
        }
    const auto renumber = [&](auto &lists) {
        for (auto &nodes : lists)
            for (int &node : nodes)
                node = rest.number[node];
    };
    renumber(mesh.tetrahedra);
    renumber(mesh.boundary_triangles);
    return rest;
}

/// Parts a body by the numbers that its nodes and tetrahedra keep: around each node, tetrahedra that faces join which
/// stay together have a node of their own.
/// @param is_across  whether the face between two tetrahedra may part
/// @return what has changed in the body
template <class IsAcross>
msm::Parting part_where(core::Body &body, const std::set<int> &removed, const IsAcross &is_across) {
    auto &mesh = body.mesh;
    std::map<std::array<int, 3>, std::vector<int>> at_face;
    std::vector<std::vector<int>> at_node(mesh.points.size());
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        if (!removed.contains(t)) {
            for (const auto &[a, b, c] : core::tetrahedron_faces) {
                const auto &nodes = mesh.tetrahedra[t];
                std::array face{nodes[a], nodes[b], nodes[c]};
                std::ranges::sort(face);
                at_face[face].push_back(t);
            }
            for (const int node : mesh.tetrahedra[t])
                at_node[node].push_back(t);
        }
    std::map<int, std::vector<std::pair<int, std::array<int, 3>>>> joined; // of each tetrahedron, over which face
    for (const auto &[face, both] : at_face)
        if (both.size() == 2 && !is_across(both[0], both[1])) {
            joined[both[0]].emplace_back(both[1], face);
            joined[both[1]].emplace_back(both[0], face);
        }
    const auto before = mesh.tetrahedra;
    const auto owners = tetrahedra_of_facets(mesh);
    msm::Parting parting;
    for (int node = 0; node < static_cast<int>(at_node.size()); ++node) {
        std::set<int> left(at_node[node].begin(), at_node[node].end());
        for (bool is_first = true; !left.empty(); is_first = false) {
            if (!is_first) {
                parting.parent_node.push_back(node);
                mesh.points.push_back(core::Vector3(mesh.points[node]));
            }
            for (std::vector<int> next{*left.begin()}; !next.empty();) {
                const int t = next.back();
                next.pop_back();
                if (left.erase(t) == 0)
                    continue;
                if (!is_first)
                    std::ranges::replace(mesh.tetrahedra[t], node, mesh.num_nodes() - 1);
                for (const auto &[other, face] : joined[t])
                    if (std::ranges::find(face, node) != face.end())
                        next.push_back(other);
            }
        }
    }
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        if (mesh.tetrahedra[t] != before[t]) {
            parting.tetrahedra.push_back(t);
            parting.nodes.push_back(mesh.tetrahedra[t]);
        }
    for (std::size_t f = 0; f < owners.size(); ++f)
        for (int &node : mesh.boundary_triangles[f]) {
            const auto &was = before[owners[f]];
            node = mesh.tetrahedra[owners[f]][std::ranges::find(was, node) - was.begin()];
        }
    return parting;
}

/// A blade in the plane of a point and a normal, down to a depth along z: part_where() of what it parts.
inline msm::Parting part_by_blade(core::Body &body, const std::set<int> &removed, const core::Vector3 &point,
                                  const core::Vector3 &normal, double least_z) {
    const auto middle = [&](int t) {
        core::Vector3 sum = core::Vector3::Zero();
        for (const int node : body.mesh.tetrahedra[t])
            sum += 0.25 * body.mesh.points[node];
        return sum;
    };
    return part_where(body, removed, [&](int t, int u) {
        const core::Vector3 one = middle(t), other = middle(u);
        return ((one - point).dot(normal) > 0.0) != ((other - point).dot(normal) > 0.0) &&
               0.5 * (one.z() + other.z()) > least_z;
    });
}

} // namespace livermark::tests
