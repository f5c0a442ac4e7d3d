#include "msm/springs/inversion_guard.hpp"

#include <algorithm>

#include "msm/dynamics/step_parts.hpp"
#include "msm/springs/tetrahedron_volume.hpp"
#include "msm/springs/volume_penalty.hpp"

namespace livermark::msm {

namespace {

/// Part of its volume below which a tetrahedron is pushed back.
constexpr double smallest_part = 0.5;
/// How much stiffer than the material: enough to hold a box pressed by 0.4 of its Young's modulus. Without the guard it
/// gives way below 0.2.
constexpr double stiffening = 4.0;

double modulus(const core::Material &material) {
    return stiffening * (material.lame_lambda() + 2.0 * material.shear_modulus());
}

class InversionGuard : public ElasticTerm {
  public:
    explicit InversionGuard(const core::Body &body) : tetrahedra_(body.mesh.tetrahedra) {
        const auto volumes = core::tetrahedron_volumes(body.mesh);
        for (std::size_t t = 0; t < volumes.size(); ++t) {
            const auto &material = body.materials[body.mesh.region[t]];
            least_volume_.push_back(smallest_part * volumes[t]);
            modulus_per_volume_.push_back(modulus(material) / volumes[t]);
        }
    }

    double energy(const Eigen::VectorXd &x) const override {
        double energy = 0.0;
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const double deficit = least_volume_[t] - volume_gradient(x, tetrahedra_[t]).volume;
            if (deficit > 0.0)
                energy += 0.5 * modulus_per_volume_[t] * deficit * deficit;
        }
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd & /*v*/, double /*beta*/,
                   Eigen::VectorXd &force) const override {
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto [volume, gradient] = volume_gradient(x, tetrahedra_[t]);
            const double deficit = least_volume_[t] - volume;
            if (deficit > 0.0)
                for (int a = 0; a < 4; ++a)
                    of_node(force, tetrahedra_[t][a]) += modulus_per_volume_[t] * deficit * gradient[a];
        }
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(144 * tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto block = tetrahedron_hessian(x, t, tangent);
            add_block(entries, tetrahedra_[t], block);
        }
        Eigen::SparseMatrix<double> hessian(x.size(), x.size());
        hessian.setFromTriplets(entries.begin(), entries.end());
        return hessian;
    }

    void add_block_bound(const Eigen::VectorXd & /*x*/, std::vector<Eigen::Matrix3d> & /*blocks*/) const override {}

    bool describe(StepParts &parts) const override {
        parts.tetrahedra = tetrahedra_;
        parts.least_volume = least_volume_;
        parts.guard_stiffness = modulus_per_volume_;
        return true;
    }

  private:
    Eigen::Matrix<double, 12, 12> tetrahedron_hessian(const Eigen::VectorXd &x, std::size_t t, Tangent tangent) const {
        const auto [volume, gradient] = volume_gradient(x, tetrahedra_[t]);
        const double deficit = least_volume_[t] - volume;
        if (tangent == Tangent::material || deficit <= 0.0)
            return Eigen::Matrix<double, 12, 12>::Zero();
        Eigen::Matrix<double, 12, 1> slope;
        for (int a = 0; a < 4; ++a)
            slope.segment<3>(3 * a) = gradient[a];
        Eigen::Matrix<double, 12, 12> hessian = slope * slope.transpose();
        if (tangent == Tangent::exact)
            hessian -= deficit * volume_hessian(x, tetrahedra_[t]);
        return modulus_per_volume_[t] * hessian;
    }

    std::vector<std::array<int, 4>> tetrahedra_;
    std::vector<double> least_volume_;       // (M) [m^3]
    std::vector<double> modulus_per_volume_; // (M) [Pa/m^3]
};

} // namespace

std::shared_ptr<const ElasticTerm> inversion_guard(const core::Body &body) {
    return std::make_shared<InversionGuard>(body);
}

std::shared_ptr<const ElasticTerm> pressed_guard(const core::Body &body) {
    ControlVolumes tetrahedra;
    tetrahedra.share.resize(body.mesh.num_tetrahedra(), body.mesh.num_tetrahedra());
    tetrahedra.share.setIdentity();
    for (const int region : body.mesh.region)
        tetrahedra.modulus.push_back(modulus(body.materials[region]));
    return volume_penalty(body.mesh, tetrahedra);
}

} // namespace livermark::msm
