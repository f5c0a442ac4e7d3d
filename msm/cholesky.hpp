#pragma once

#include <Eigen/SparseCore>
#include <memory>

namespace livermark::msm {

/// Sparse Cholesky factorisation, ordered by nested dissection: of a solid with a volume term it fills half as much as
/// minimum degree, and there is one ordering to find instead of the best of several.
class Cholesky {
  public:
    Cholesky();
    ~Cholesky();
    Cholesky(Cholesky &&) noexcept;
    Cholesky &operator=(Cholesky &&) noexcept;

    /// @param matrix  symmetric, both triangles; entries in the same places every time
    /// @return whether it is positive definite
    bool factorize(const Eigen::SparseMatrix<double> &matrix);
    /// Only after a factorize() that returned true.
    Eigen::VectorXd solve(const Eigen::VectorXd &right_hand_side) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::msm
