#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace livermark::support {

/// Sparse Cholesky factor (CHOLMOD, simplicial), P A P^T = L D L^T, that follows when columns are added to the matrix
/// or taken away: A + C C^T or A - C C^T. (Davis, Hager 2001, Multiple-rank modifications of a sparse Cholesky
/// factorization, SIAM J. Matrix Anal. Appl. 22)
///
/// A change of a few columns takes less time than another factor; for many it does not, as each goes up the whole
/// elimination tree: docs/studies/cutting.md has times.
class UpdatedCholesky {
  public:
    using Matrix = Eigen::SparseMatrix<double>;

    /// @param matrix  symmetric and positive definite, of which the upper triangle is read
    /// @throws std::bad_alloc if there is too little memory
    explicit UpdatedCholesky(const Matrix &matrix);
    ~UpdatedCholesky();
    UpdatedCholesky(UpdatedCholesky &&) noexcept;
    UpdatedCholesky &operator=(UpdatedCholesky &&) noexcept;

    /// Adds C C^T to the matrix, or takes it away; what is left has to be positive definite.
    /// @param columns  C, shape (n, any)
    void add(const Matrix &columns);
    void subtract(const Matrix &columns);

    Eigen::VectorXd solve(const Eigen::VectorXd &right_hand_side) const;

  private:
    void change(bool adds, const Matrix &columns);

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::support
