#pragma once

#include <Eigen/LU>
#include <array>
#include <utility>
#include <vector>

#include "interactive/kernels/node_rows.hpp"
#include "interactive/scene.hpp"

namespace livermark::interactive {

/// The three numbers of a node in rows of four.
inline Eigen::Map<Eigen::Vector3f> in_row(kernels::Aligned<float> &rows, int row) {
    return Eigen::Map<Eigen::Vector3f>(rows.data() + 4 * static_cast<Eigen::Index>(row));
}
inline Eigen::Map<const Eigen::Vector3f> in_row(const kernels::Aligned<float> &rows, int row) {
    return Eigen::Map<const Eigen::Vector3f>(rows.data() + 4 * static_cast<Eigen::Index>(row));
}

/// A row in single precision, and where it is measured from, as one vector in double precision.
class FineRow {
  public:
    FineRow(core::Vector3 origin, const Eigen::Map<Eigen::Vector3f> &row) : origin_(std::move(origin)), row_(row) {}
    operator core::Vector3() const { return origin_ + row_.cast<double>(); } // NOLINT(google-explicit-constructor)
    void operator+=(const core::Vector3 &change) { row_ = (row_.cast<double>() + change).cast<float>(); }

  private:
    core::Vector3 origin_;
    Eigen::Map<Eigen::Vector3f> row_;
};

/// @param row_of_node  (N)
inline void put_into_rows(const Field &field, const std::vector<int> &row_of_node, kernels::Aligned<float> &rows) {
    for (Eigen::Index i = 0; i < field.cols(); ++i)
        in_row(rows, row_of_node[i]) = field.col(i).cast<float>();
}

inline void take_from_rows(const kernels::Aligned<float> &rows, const std::vector<int> &row_of_node, Field &field) {
    for (Eigen::Index i = 0; i < field.cols(); ++i)
        field.col(i) = in_row(rows, row_of_node[i]).cast<double>();
}

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
