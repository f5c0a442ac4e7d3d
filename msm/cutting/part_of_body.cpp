#include "msm/cutting/part_of_body.hpp"

#include <cstddef>
#include <numeric>
#include <utility>

#include "msm/dynamics/time_step.hpp"

namespace livermark::msm {

PartOfBody part_of_body(const core::Body &body, const std::vector<char> &is_in, const NodalConditions &conditions) {
    const auto &mesh = body.mesh;
    PartOfBody part{.body = {.name = body.name, .mesh = {}, .materials = body.materials}, .node = {}, .conditions = {}};
    auto &of_part = part.body.mesh;
    of_part.region_names = mesh.region_names;
    std::vector<int> number(mesh.points.size(), -1);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        if (is_in[t] == 0)
            continue;
        for (const int node : of_part.tetrahedra.emplace_back(mesh.tetrahedra[t]))
            number[node] = 0;
        of_part.region.push_back(mesh.region[t]);
    }
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] == 0) {
            number[i] = of_part.num_nodes();
            part.node.push_back(static_cast<int>(i));
            of_part.points.push_back(mesh.points[i]);
            part.conditions.displacement.push_back(conditions.displacement[i]);
            part.conditions.force.emplace_back(core::Vector3::Zero());
            part.conditions.constraint.push_back({-1, -1, -1});
        }
    for (auto &tetrahedron : of_part.tetrahedra)
        for (int &node : tetrahedron)
            node = number[node];
    return part;
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

KeptNumbers::KeptNumbers(const core::TetraMesh &mesh)
    : tetrahedra_(mesh.tetrahedra), node_(mesh.points.size()), tetrahedron_(mesh.tetrahedra.size()),
      num_nodes_(mesh.num_nodes()) {
    std::iota(node_.begin(), node_.end(), 0);
    std::iota(tetrahedron_.begin(), tetrahedron_.end(), 0);
}

FacetCut KeptNumbers::follow(const core::TetraMesh &after, const std::vector<int> &parent_tetrahedron) {
    FacetCut cut;
    std::vector<int> left, parent(after.points.size(), -1);
    std::size_t next = 0;
    for (std::size_t t = 0; t < tetrahedron_.size(); ++t) {
        if (next == parent_tetrahedron.size() || parent_tetrahedron[next] != static_cast<int>(t)) {
            cut.removed.push_back(tetrahedron_[t]);
            continue;
        }
        left.push_back(tetrahedron_[t]);
        for (std::size_t k = 0; k < 4; ++k)
            parent[after.tetrahedra[next][k]] = tetrahedra_[tetrahedron_[t]][k];
        ++next;
    }
    std::vector<char> is_taken(static_cast<std::size_t>(num_nodes_), 0);
    node_.resize(after.points.size());
    for (std::size_t i = 0; i < node_.size(); ++i) {
        if (is_taken[parent[i]] == 0) {
            is_taken[parent[i]] = 1;
            node_[i] = parent[i];
            continue;
        }
        node_[i] = num_nodes_++;
        cut.parting.parent_node.push_back(parent[i]);
    }
    tetrahedron_ = std::move(left);
    for (std::size_t t = 0; t < tetrahedron_.size(); ++t) {
        std::array<int, 4> nodes{};
        for (std::size_t k = 0; k < 4; ++k)
            nodes[k] = node_[after.tetrahedra[t][k]];
        if (nodes == tetrahedra_[tetrahedron_[t]])
            continue;
        tetrahedra_[tetrahedron_[t]] = nodes;
        cut.parting.tetrahedra.push_back(tetrahedron_[t]);
        cut.parting.nodes.push_back(nodes);
    }
    return cut;
}

} // namespace livermark::msm
