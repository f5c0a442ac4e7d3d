#include "msm/cutting/kept_numbers.hpp"

#include <cstddef>
#include <numeric>
#include <utility>

namespace livermark::msm {

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
