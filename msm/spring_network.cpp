#include "msm/spring_network.hpp"

#include <algorithm>

#include "msm/mass_lumping.hpp"

namespace livermark::msm {

core::SpringNetwork spring_network(const core::Body &body, const SpringLaw &law) {
    auto table = core::edge_table(body.mesh.tetrahedra);
    core::SpringNetwork springs;
    springs.node_mass = lumped_masses(body);
    springs.stiffness = law.stiffness(body, table);
    springs.rest_length.reserve(table.edges.size());
    for (const auto &[i, j] : table.edges)
        springs.rest_length.push_back((body.mesh.points[j] - body.mesh.points[i]).norm());
    springs.edges = std::move(table.edges);
    return springs;
}

double elastic_energy(const core::SpringNetwork &springs, const std::vector<core::Vector3> &positions) {
    double energy = 0.0;
    for (std::size_t s = 0; s < springs.edges.size(); ++s) {
        const auto [i, j] = springs.edges[s];
        const double extension = (positions[j] - positions[i]).norm() - springs.rest_length[s];
        energy += 0.5 * springs.stiffness[s] * extension * extension;
    }
    return energy;
}

std::vector<core::Vector3> elastic_gradient(const core::SpringNetwork &springs,
                                            const std::vector<core::Vector3> &positions) {
    std::vector<core::Vector3> gradient(positions.size(), core::Vector3::Zero());
    for (std::size_t s = 0; s < springs.edges.size(); ++s) {
        const auto [i, j] = springs.edges[s];
        const core::Vector3 span = positions[j] - positions[i];
        const core::Vector3 pull = springs.stiffness[s] * (1.0 - springs.rest_length[s] / span.norm()) * span;
        gradient[i] -= pull;
        gradient[j] += pull;
    }
    return gradient;
}

Eigen::SparseMatrix<double> elastic_hessian(const core::SpringNetwork &springs,
                                            const std::vector<core::Vector3> &positions, Tangent tangent) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(36 * springs.edges.size());
    const auto add = [&entries](int row, int column, const Eigen::Matrix3d &block, double sign) {
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                entries.emplace_back(3 * row + a, 3 * column + b, sign * block(a, b));
    };
    for (std::size_t s = 0; s < springs.edges.size(); ++s) {
        const auto [i, j] = springs.edges[s];
        const core::Vector3 span = positions[j] - positions[i];
        const core::Vector3 direction = span.normalized();
        double transverse = 1.0 - springs.rest_length[s] / span.norm();
        if (tangent == Tangent::semi_definite)
            transverse = std::max(transverse, 0.0);
        else if (tangent == Tangent::axial)
            transverse = 0.0;
        const Eigen::Matrix3d axial = direction * direction.transpose();
        const Eigen::Matrix3d block =
            springs.stiffness[s] * (axial + transverse * (Eigen::Matrix3d::Identity() - axial));
        add(i, i, block, 1.0);
        add(j, j, block, 1.0);
        add(i, j, block, -1.0);
        add(j, i, block, -1.0);
    }
    const auto size = static_cast<Eigen::Index>(3 * positions.size());
    Eigen::SparseMatrix<double> hessian(size, size);
    hessian.setFromTriplets(entries.begin(), entries.end());
    return hessian;
}

} // namespace livermark::msm
