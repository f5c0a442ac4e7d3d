#include "fem_reference/hyperelastic/follower_pressure.hpp"

#include <Eigen/Geometry>
#include <stdexcept>
#include <string>

namespace livermark::hyperelastic {

namespace {

using core::Vector3;
using Tangents = Eigen::Matrix<double, 3, 2>;

/// x_r and x_s.
Tangents tangents(const fem_reference::ElasticSystem &system, const std::vector<int> &nodes,
                  const Eigen::Matrix2Xd &gradients, const std::vector<double> &displacement) {
    Tangents sum = Tangents::Zero();
    for (std::size_t a = 0; a < nodes.size(); ++a)
        sum += (system.points[nodes[a]] + Vector3::Map(&displacement[3 * nodes[a]])) * gradients.col(a).transpose();
    return sum;
}

/// The matrix of v -> a cross v.
Eigen::Matrix3d cross_matrix(const Vector3 &a) {
    Eigen::Matrix3d matrix;
    matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
    return matrix;
}

} // namespace

FollowerPressure::FollowerPressure(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh,
                                   std::span<const double> pressure)
    : system_(&system), reference_(reference_triangle(system.nodes_per_facet == 3 ? 1 : 2)) {
    if (!pressure.empty() && pressure.size() != mesh.boundary_triangles.size())
        throw std::invalid_argument("follower pressures are given for " + std::to_string(pressure.size()) +
                                    " facets of " + std::to_string(mesh.boundary_triangles.size()));
    for (std::size_t f = 0; f < pressure.size(); ++f)
        if (pressure[f] < 0.0 || pressure[f] > 0.0)
            facets_.push_back({nodes_of_facet(system, mesh, f), pressure[f]});
}

void FollowerPressure::add_forces(double factor, const std::vector<double> &displacement,
                                  std::vector<double> &force) const {
    for (const auto &facet : facets_)
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const Tangents x = tangents(*system_, facet.nodes, reference_.gradient[q], displacement);
            const Vector3 area = x.col(0).cross(x.col(1));
            for (std::size_t a = 0; a < facet.nodes.size(); ++a)
                Vector3::Map(&force[3 * facet.nodes[a]]) -=
                    factor * facet.pressure * reference_.weight[q] * reference_.shape[q][a] * area;
        }
}

SurfaceStiffness FollowerPressure::load_stiffness(double factor, const std::vector<double> &displacement) const {
    SurfaceStiffness result;
    for (const auto &facet : facets_) {
        const auto num_nodes = static_cast<Eigen::Index>(facet.nodes.size());
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * num_nodes, 3 * num_nodes);
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const auto &gradients = reference_.gradient[q];
            const Tangents x = tangents(*system_, facet.nodes, gradients, displacement);
            const Eigen::Matrix3d along_r = cross_matrix(x.col(0)), along_s = cross_matrix(x.col(1));
            const double weight = factor * facet.pressure * reference_.weight[q];
            for (Eigen::Index b = 0; b < num_nodes; ++b) {
                // The change of x_r cross x_s as node b moves.
                const Eigen::Matrix3d of_area = weight * (gradients(1, b) * along_r - gradients(0, b) * along_s);
                for (Eigen::Index a = 0; a < num_nodes; ++a)
                    matrix.block<3, 3>(3 * a, 3 * b) += reference_.shape[q][a] * of_area;
            }
        }
        result.add({facet.nodes, 0.5 * (matrix + matrix.transpose()), 0.5 * (matrix - matrix.transpose())});
    }
    return result;
}

} // namespace livermark::hyperelastic
