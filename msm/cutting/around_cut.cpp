#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "msm/cutting/cut_parts.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::msm {

PartOfBody part_of_body(const core::Body &body, const std::vector<char> &is_in, const NodalConditions &conditions) {
    const auto &mesh = body.mesh;
    PartOfBody part{.body = {.name = body.name,
                             .mesh = {},
                             .materials = body.materials,
                             .capsule = body.capsule,
                             .vessels = body.vessels},
                    .node = {},
                    .tetrahedron = {},
                    .conditions = {}};
    auto &mesh_of_part = part.body.mesh;
    mesh_of_part.region_names = mesh.region_names;
    std::vector<int> number(mesh.points.size(), -1);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        if (is_in[t] == 0)
            continue;
        for (const int node : mesh_of_part.tetrahedra.emplace_back(mesh.tetrahedra[t]))
            number[node] = 0;
        part.tetrahedron.push_back(static_cast<int>(t));
        mesh_of_part.region.push_back(mesh.region[t]);
        if (!body.modulus_factor.empty())
            part.body.modulus_factor.push_back(body.modulus_factor[t]);
    }
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] == 0) {
            number[i] = mesh_of_part.num_nodes();
            part.node.push_back(static_cast<int>(i));
            mesh_of_part.points.push_back(mesh.points[i]);
            part.conditions.displacement.push_back(conditions.displacement[i]);
            part.conditions.force.emplace_back(core::Vector3::Zero());
            part.conditions.constraint.push_back({-1, -1, -1});
        }
    for (auto &tetrahedron : mesh_of_part.tetrahedra)
        for (int &node : tetrahedron)
            node = number[node];
    mesh_of_part.patch_names = mesh.patch_names;
    for (const auto &[tetrahedron, corners, facet] : covered_faces(body))
        if (is_in[tetrahedron] != 0) {
            for (int &node : mesh_of_part.boundary_triangles.emplace_back(mesh.boundary_triangles[facet]))
                node = number[node];
            mesh_of_part.boundary_patch.push_back(mesh.boundary_patch[facet]);
        }
    return part;
}

std::shared_ptr<const ElasticTerm> term_of_part(const ElasticTerm &whole, const PartOfBody &part,
                                                std::size_t num_tetrahedra) {
    const auto rest = to_unknowns(part.body.mesh.points);
    std::vector<std::array<int, 4>> nodes(num_tetrahedra);
    std::vector<char> is_removed(num_tetrahedra, 1);
    for (std::size_t t = 0; t < part.tetrahedron.size(); ++t) {
        const auto number = static_cast<std::size_t>(part.tetrahedron[t]);
        nodes[number] = part.body.mesh.tetrahedra[t];
        is_removed[number] = 0;
    }
    return whole.after_cut({rest, nodes, is_removed});
}

namespace {

/// Rings of tetrahedra with nodes that move, and rings around these that their springs and means have to know.
constexpr int moving_rings = 2, known_rings = 3;

/// Marks the nodes of the tetrahedra that are left at marked nodes as well.
void add_ring(const core::TetraMesh &mesh, const std::vector<char> &is_removed, std::vector<char> &marked) {
    const auto before = marked;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        if (is_removed[t] == 0 && (before[a] != 0 || before[b] != 0 || before[c] != 0 || before[d] != 0))
            for (const int node : mesh.tetrahedra[t])
                marked[node] = 1;
    }
}

} // namespace

double frequency_around(const core::Body &body, const std::vector<char> &is_removed, std::span<const int> nodes,
                        const std::function<ElasticBody(const PartOfBody &)> &make, const NodalConditions &conditions,
                        double tolerance) {
    const auto &mesh = body.mesh;
    std::vector<char> moves(mesh.points.size(), 0);
    for (const int node : nodes)
        moves[node] = 1;
    for (int ring = 0; ring < moving_rings; ++ring)
        add_ring(mesh, is_removed, moves);
    auto is_known = moves;
    for (int ring = 1; ring < known_rings; ++ring)
        add_ring(mesh, is_removed, is_known);
    std::vector<char> is_in(mesh.tetrahedra.size(), 0);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        is_in[t] = is_removed[t] == 0 && (is_known[a] != 0 || is_known[b] != 0 || is_known[c] != 0 || is_known[d] != 0);
    }
    auto part = part_of_body(body, is_in, conditions);
    if (part.node.empty())
        return 0.0;
    for (std::size_t i = 0; i < part.node.size(); ++i)
        if (moves[part.node[i]] == 0)
            part.conditions.displacement[i].setZero();
    return largest_angular_frequency(make(part), part.body.mesh.points, part.conditions, {}, tolerance);
}

} // namespace livermark::msm
