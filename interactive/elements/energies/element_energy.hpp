#pragma once

#include <Eigen/Eigenvalues>
#include <utility>

#include "interactive/elements/energies/densities.hpp"
#include "interactive/energy.hpp"

namespace livermark::interactive {

/// The same matrix with its negative eigenvalues at zero.
template <int n> Eigen::Matrix<double, n, n> without_negative_eigenvalues(const Eigen::Matrix<double, n, n> &matrix) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, n, n>> solver(matrix);
    return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * solver.eigenvectors().transpose();
}

/// Adds V dN : dP/dF : dN of a tetrahedron.
inline void add_tangent(const Tetrahedron &tetrahedron, const densities::Tangent &tangent, Energy::Triplets &triplets) {
    const auto gradients = tetrahedron.shape_gradients();
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) {
            Matrix3 block = Matrix3::Zero();
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    block += gradients(a, j) * gradients(b, l) * tangent.block<3, 3>(3 * j, 3 * l);
            block *= tetrahedron.volume;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k)
                    triplets.emplace_back(3 * tetrahedron.nodes[a] + i, 3 * tetrahedron.nodes[b] + k, block(i, k));
        }
}

/// W = sum over the tetrahedra of V times a density of densities.hpp.
template <class Density> class ElementEnergy : public Energy {
  public:
    explicit ElementEnergy(std::vector<Tetrahedron> tetrahedra) : tetrahedra_(std::move(tetrahedra)) {}

    double value(const Field &x) const override {
        double value = 0.0;
        for (const auto &t : tetrahedra_)
            value += t.volume * Density{t.mu, t.lambda}.value(t.gradient(x));
        return value;
    }

    void add_forces(const Field &x, Field &f) const override {
        for (const auto &t : tetrahedra_)
            t.add_forces(Density{t.mu, t.lambda}.stress(t.gradient(x)), f);
    }

    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override {
        triplets.reserve(triplets.size() + 144 * tetrahedra_.size());
        for (const auto &t : tetrahedra_) {
            const densities::Tangent tangent = Density{t.mu, t.lambda}.tangent(t.gradient(x));
            add_tangent(t, is_projected ? without_negative_eigenvalues(tangent) : tangent, triplets);
        }
    }

    const std::vector<Tetrahedron> &tetrahedra() const { return tetrahedra_; }

  private:
    std::vector<Tetrahedron> tetrahedra_;
};

} // namespace livermark::interactive
