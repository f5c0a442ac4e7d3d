#pragma once

#include <Eigen/Eigenvalues>

namespace livermark::core {

/// The nearest matrix without negative eigenvalues, in the norm of Frobenius.
/// @param matrix  symmetric
template <class Matrix> Matrix semi_definite_part(const Matrix &matrix) {
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(matrix);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

} // namespace livermark::core
