#include "interactive/elements/critical_step.hpp"

#include <Eigen/Eigenvalues>
#include <Spectra/SymEigsSolver.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/elements/energies/element_energy.hpp"

namespace livermark::interactive {

namespace {

/// M^-1/2 K M^-1/2 over the free components, for Spectra.
class ScaledStiffness {
  public:
    using Scalar = double;

    ScaledStiffness(const Energy &energy, const Scene &scene) : energy_(&energy), rest_(rest_positions(scene)) {
        const auto is_free = free_nodes(scene);
        for (Eigen::Index i = 0; i < rest_.cols(); ++i)
            if (is_free[i]) {
                nodes_.push_back(i);
                root_.push_back(1.0 / std::sqrt(scene.node_mass[i]));
            }
        // As small against an element as leaves half of the digits.
        constexpr double part_of_body = 1e-7;
        length_ = part_of_body * core::extent(scene.body->mesh.points);
    }

    Eigen::Index rows() const { return 3 * static_cast<Eigen::Index>(nodes_.size()); }
    Eigen::Index cols() const { return rows(); }

    void perform_op(const double *in, double *out) const {
        Field move = Field::Zero(3, rest_.cols());
        for (std::size_t k = 0; k < nodes_.size(); ++k)
            move.col(nodes_[k]) = root_[k] * core::Vector3(in[3 * k], in[3 * k + 1], in[3 * k + 2]);
        const double largest = move.cwiseAbs().maxCoeff();
        const double factor = largest > 0.0 ? length_ / largest : 1.0;
        Field behind = Field::Zero(3, rest_.cols()), ahead = behind;
        energy_->add_forces(rest_ - factor * move, behind);
        energy_->add_forces(rest_ + factor * move, ahead);
        for (std::size_t k = 0; k < nodes_.size(); ++k)
            Eigen::Map<core::Vector3>(out + 3 * k) =
                root_[k] / (2.0 * factor) * (behind.col(nodes_[k]) - ahead.col(nodes_[k]));
    }

  private:
    const Energy *energy_;
    Field rest_;
    std::vector<Eigen::Index> nodes_; ///< that are free
    std::vector<double> root_;        ///< of one over their masses
    double length_ = 0.0;             ///< of the differences [m]
};

} // namespace

double critical_time_step(const Energy &energy, const Scene &scene) {
    ScaledStiffness operation(energy, scene);
    if (operation.rows() == 0)
        return std::numeric_limits<double>::infinity();
    constexpr Eigen::Index num_vectors = 24;
    constexpr int most_restarts = 200;
    constexpr double tolerance = 1e-4;
    Spectra::SymEigsSolver<ScaledStiffness> solver(operation, 1, std::min(num_vectors, operation.rows()));
    solver.init();
    if (solver.compute(Spectra::SortRule::LargestAlge, most_restarts, tolerance) < 1)
        throw std::runtime_error("the highest frequency of the body is not found");
    return 2.0 / std::sqrt(solver.eigenvalues()[0]);
}

double critical_time_step_bound(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass) {
    std::vector<double> node_volume(node_mass.size(), 0.0);
    for (const auto &t : tetrahedra)
        for (const int node : t.nodes)
            node_volume[node] += t.volume;
    double highest = 0.0;
    for (const auto &t : tetrahedra) {
        const auto gradients = t.shape_gradients();
        Eigen::Matrix<double, 12, 9> strain; // dF of unit moves, over the roots of masses
        for (int a = 0; a < 4; ++a) {
            const double mass = node_mass[t.nodes[a]] * t.volume / node_volume[t.nodes[a]];
            for (int j = 0; j < 3; ++j)
                strain.block<3, 3>(3 * a, 3 * j) = gradients(a, j) / std::sqrt(mass) * Matrix3::Identity();
        }
        const densities::Tangent tangent = densities::NeoHookean{t.mu, t.lambda}.tangent(Matrix3::Identity());
        const Eigen::Matrix<double, 12, 12> matrix = t.volume * strain * tangent * strain.transpose();
        highest = std::max(highest,
                           Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>>(matrix, Eigen::EigenvaluesOnly)
                               .eigenvalues()
                               .maxCoeff());
    }
    return 2.0 / std::sqrt(highest);
}

} // namespace livermark::interactive
