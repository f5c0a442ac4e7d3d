#include "load_cases/round_tool.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace livermark::load_cases {

namespace {

using core::Vector3;

/// A facet is cut into rows^2 alike, so that of a share at the rim a thousandth is left.
constexpr int rows = 24;

/// Calls visit(barycentric coordinates of the centroid) for each part of a triangle.
template <class Visit> void visit_parts(Visit visit) {
    const auto part = [&](double i, double j) { visit(Vector3(rows - i - j, i, j) / rows); };
    for (int i = 0; i < rows; ++i)
        for (int j = 0; i + j < rows; ++j) {
            part(i + 1.0 / 3.0, j + 1.0 / 3.0);
            if (i + j + 1 < rows)
                part(i + 2.0 / 3.0, j + 2.0 / 3.0);
        }
}

Vector3 point_at(const core::TetraMesh &mesh, int facet, const Vector3 &barycentric) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return barycentric[0] * mesh.points[a] + barycentric[1] * mesh.points[b] + barycentric[2] * mesh.points[c];
}

} // namespace

std::vector<double> sinking(const RoundTool &tool, const core::TetraMesh &mesh, const std::vector<int> &facets) {
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
        visit_parts([&](const Vector3 &at) {
            const double depth = std::max(0.0, 1.0 - 0.5 * tool.squared_radius(point_at(mesh, f, at)));
            for (std::size_t k = 0; k < 3; ++k)
                moment[place[k]] += area / (rows * rows) * depth * at[static_cast<Eigen::Index>(k)];
        });
    }
    const Eigen::VectorXd nearest = mass.llt().solve(moment);
    std::vector<double> factor(mesh.points.size(), 1.0);
    for (Eigen::Index k = 0; k < num_nodes; ++k)
        factor[nodes[k]] = std::max(0.0, nearest[k]);
    return factor;
}

double mean_pressure(const RoundTool &tool, const core::TetraMesh &mesh, int facet) {
    double sum = 0.0;
    visit_parts([&](const Vector3 &at) {
        sum += 1.5 * std::sqrt(std::max(0.0, 1.0 - tool.squared_radius(point_at(mesh, facet, at))));
    });
    return sum / (rows * rows);
}

} // namespace livermark::load_cases
