#include "msm/cutting/frequency_around.hpp"

#include <utility>

#include "msm/dynamics/highest_frequency.hpp"

namespace livermark::msm {

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
                        const std::function<ElasticBody(const core::Body &)> &make, const NodalConditions &conditions,
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
    core::Body part{.name = body.name, .mesh = {}, .materials = body.materials};
    part.mesh.region_names = mesh.region_names;
    std::vector<int> number(mesh.points.size(), -1);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        if (is_removed[t] != 0 || (is_known[a] == 0 && is_known[b] == 0 && is_known[c] == 0 && is_known[d] == 0))
            continue;
        for (int &node : part.mesh.tetrahedra.emplace_back(mesh.tetrahedra[t])) {
            number[node] = 0;
        }
        part.mesh.region.push_back(mesh.region[t]);
    }
    NodalConditions of_part;
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] == 0) {
            number[i] = part.mesh.num_nodes();
            part.mesh.points.push_back(mesh.points[i]);
            of_part.displacement.push_back(moves[i] != 0 ? conditions.displacement[i] : core::Vector3::Zero());
            of_part.force.push_back(core::Vector3::Zero());
            of_part.constraint.push_back({-1, -1, -1});
        }
    if (part.mesh.points.empty())
        return 0.0;
    for (auto &tetrahedron : part.mesh.tetrahedra)
        for (int &node : tetrahedron)
            node = number[node];
    return largest_angular_frequency(make(part), part.mesh.points, of_part, {}, tolerance);
}

} // namespace livermark::msm
