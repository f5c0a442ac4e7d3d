#pragma once

#include <memory>
#include <vector>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::tests {

/// Linear elements of Saint Venant and Kirchhoff's material: the energy of each tetrahedron is V (lambda / 2 (tr E)^2 +
/// mu E : E) of its Green strain E.
class LinearElements : public msm::ElasticTerm {
  public:
    /// @param body  at rest, positive volumes
    explicit LinearElements(const core::Body &body)
        : nodes_(body.mesh.tetrahedra), volume_(core::tetrahedron_volumes(body.mesh)) {
        const auto rest = msm::to_unknowns(body.mesh.points);
        for (std::size_t t = 0; t < nodes_.size(); ++t) {
            const auto &material = body.materials[body.mesh.region[t]];
            strain_.emplace_back(nodes_[t], rest);
            moduli_.push_back(msm::isotropic_stiffness(material.lame_lambda(), material.shear_modulus()));
        }
    }

    double energy(const Eigen::VectorXd &x) const override {
        double energy = 0.0;
        for (std::size_t t = 0; t < nodes_.size(); ++t)
            energy += 0.5 * volume_[t] * strain_[t].of(x).dot(moduli_[t] * strain_[t].of(x));
        return energy;
    }
    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (std::size_t t = 0; t < nodes_.size(); ++t) {
            msm::Vector6 strain = strain_[t].of(x);
            if (beta != 0.0)
                strain += beta * strain_[t].rate(x, v);
            strain_[t].add_force(x, volume_[t] * moduli_[t] * strain, force);
        }
    }
    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, msm::Tangent tangent) const override {
        return msm::sum_of_blocks(nodes_, x.size(), [&](std::size_t t) { return block(x, t, tangent); });
    }
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (std::size_t t = 0; t < nodes_.size(); ++t)
            for (int a = 0; a < 4; ++a)
                blocks[nodes_[t][a]] += 4.0 * block(x, t, msm::Tangent::material).block<3, 3>(3 * a, 3 * a);
    }

  private:
    msm::Matrix12 block(const Eigen::VectorXd &x, std::size_t t, msm::Tangent tangent) const {
        const auto slope = strain_[t].slope(x);
        const msm::Vector6 stress = volume_[t] * moduli_[t] * strain_[t].of(x);
        return volume_[t] * slope.transpose() * moduli_[t] * slope + strain_[t].curvature(x, stress, tangent);
    }

    std::vector<std::array<int, 4>> nodes_;
    std::vector<double> volume_; ///< (M) [m^3]
    std::vector<msm::SquaredLengths> strain_;
    std::vector<msm::Matrix6> moduli_; ///< (M) [Pa]
};

inline std::shared_ptr<const msm::ElasticTerm> linear_elements(const core::Body &body) {
    return std::make_shared<LinearElements>(body);
}

} // namespace livermark::tests
