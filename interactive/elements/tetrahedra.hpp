#pragma once

#include <Eigen/LU>
#include <array>
#include <vector>

#include "interactive/scene.hpp"

namespace livermark::interactive {

using Matrix3 = Eigen::Matrix3d;

/// A linear tetrahedron at rest. Its deformation gradient is F = D B with D the edges from the first corner, by
/// columns.
struct Tetrahedron {
    std::array<int, 4> nodes;
    Matrix3 inverse_edges; ///< B, the inverse of the edges at rest [1/m]
    double volume;         ///< at rest [m^3]
    double mu, lambda;     ///< Lame parameters [Pa]

    Matrix3 gradient(const Field &x) const {
        Matrix3 edges;
        for (int c = 0; c < 3; ++c)
            edges.col(c) = x.col(nodes[c + 1]) - x.col(nodes[0]);
        return edges * inverse_edges;
    }

    /// Gradients of the four shape functions at rest, shape (4, 3) [1/m].
    Eigen::Matrix<double, 4, 3> shape_gradients() const {
        Eigen::Matrix<double, 4, 3> gradients;
        gradients.bottomRows<3>() = inverse_edges;
        gradients.row(0) = -inverse_edges.colwise().sum();
        return gradients;
    }

    /// f -= V P grad N [N], with P the first Piola-Kirchhoff stress [Pa].
    void add_forces(const Matrix3 &stress, Field &f) const {
        const Matrix3 forces = volume * stress * inverse_edges.transpose();
        f.col(nodes[0]) += forces.rowwise().sum();
        for (int c = 0; c < 3; ++c)
            f.col(nodes[c + 1]) -= forces.col(c);
    }
};

/// The tetrahedra of a body, in the order of its mesh.
std::vector<Tetrahedron> tetrahedra_at_rest(const core::Body &body);

/// d det F / dF, the matrix of cofactors.
inline Matrix3 cofactors(const Matrix3 &f) {
    Matrix3 result;
    result.col(0) = f.col(1).cross(f.col(2));
    result.col(1) = f.col(2).cross(f.col(0));
    result.col(2) = f.col(0).cross(f.col(1));
    return result;
}

} // namespace livermark::interactive
