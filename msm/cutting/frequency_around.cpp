#include "msm/cutting/frequency_around.hpp"

#include "msm/cutting/part_of_body.hpp"
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
    return largest_angular_frequency(make(part.body), part.body.mesh.points, part.conditions, {}, tolerance);
}

} // namespace livermark::msm
