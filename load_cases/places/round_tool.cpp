#include "load_cases/places/round_tool.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace livermark::load_cases {

std::vector<double> sinking(const core::RoundLoad &tool, const core::TetraMesh &mesh, const std::vector<int> &facets) {
    std::vector<int> nodes;
    for (const int f : facets)
        nodes.insert(nodes.end(), mesh.boundary_triangles[f].begin(), mesh.boundary_triangles[f].end());
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    const auto num_nodes = std::ssize(nodes);
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(num_nodes, num_nodes);
    Eigen::VectorXd moment = Eigen::VectorXd::Zero(num_nodes);
    for (const int f : facets) {
        std::array<Eigen::Index, 3> place{};
        std::ranges::transform(mesh.boundary_triangles[f], place.begin(),
                               [&](int node) { return std::ranges::lower_bound(nodes, node) - nodes.begin(); });
        const double area = area_vector(mesh, f).norm();
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t l = 0; l < 3; ++l)
                mass(place[k], place[l]) += area / (k == l ? 6.0 : 12.0);
        const auto corners = core::corners_of(mesh, f);
        core::visit_triangle_parts([&](const core::Vector3 &at) {
            const core::Vector3 point = core::point_at(corners, at);
            const double ratio = (point - tool.middle).norm() / tool.radius;
            const double depth = std::max(0.0, 1.0 - 0.5 * ratio * ratio);
            for (std::size_t k = 0; k < 3; ++k)
                moment[place[k]] += area / core::num_triangle_parts * depth * at[static_cast<Eigen::Index>(k)];
        });
    }
    const Eigen::VectorXd nearest = mass.llt().solve(moment);
    std::vector<double> factor(mesh.points.size(), 1.0);
    for (Eigen::Index k = 0; k < num_nodes; ++k)
        factor[nodes[k]] = std::max(0.0, nearest[k]);
    return factor;
}

} // namespace livermark::load_cases
