#include "fem_reference/hyperelastic/surface/surface_stiffness.hpp"

#include <algorithm>

namespace livermark::hyperelastic {

using core::Vector3;

std::vector<int> nodes_of_facet(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh,
                                std::size_t facet) {
    std::vector<int> nodes;
    for (const int corner : mesh.boundary_triangles[facet])
        nodes.push_back(system.mesh_node[corner]);
    const auto there =
        std::span(system.facet_nodes).subspan(facet * system.nodes_per_facet, system.nodes_per_facet).subspan(3);
    for (std::size_t k = 0; k < there.size(); ++k) {
        const Vector3 middle = 0.5 * (system.points[nodes[k]] + system.points[nodes[(k + 1) % 3]]);
        nodes.push_back(*std::ranges::min_element(
            there, {}, [&](int node) { return (system.points[node] - middle).squaredNorm(); }));
    }
    return nodes;
}

void SurfaceStiffness::add_to(fem_reference::SymmetricBlocks<double> &stiffness) const {
    const auto &rows = stiffness.rows;
    for (const auto &facet : of_facet_) {
        const auto &nodes = facet.nodes;
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b < nodes.size(); ++b) {
                if (nodes[b] > nodes[a])
                    continue;
                const auto first = rows.column.begin() + rows.row_start[nodes[a]],
                           last = rows.column.begin() + rows.row_start[nodes[a] + 1];
                auto &block = a == b ? stiffness.diagonal[nodes[a]]
                                     : stiffness.below[std::lower_bound(first, last, nodes[b]) - rows.column.begin()];
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j)
                        block[3 * i + j] +=
                            facet.symmetric(static_cast<Eigen::Index>(3 * a + i), static_cast<Eigen::Index>(3 * b + j));
            }
    }
}

void SurfaceStiffness::add_product(std::span<const double> x, std::span<double> out) const {
    for (const auto &facet : of_facet_) {
        const auto &nodes = facet.nodes;
        Eigen::VectorXd local(static_cast<Eigen::Index>(3 * nodes.size()));
        for (std::size_t a = 0; a < nodes.size(); ++a)
            local.segment<3>(static_cast<Eigen::Index>(3 * a)) = Vector3::Map(&x[3 * nodes[a]]);
        const Eigen::VectorXd product = facet.rest * local;
        for (std::size_t a = 0; a < nodes.size(); ++a)
            Vector3::Map(&out[3 * nodes[a]]) += product.segment<3>(static_cast<Eigen::Index>(3 * a));
    }
}

} // namespace livermark::hyperelastic
