#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace livermark::support {

/// Places of the entries of a supernodal triangular factor L: columns of a supernode follow each other and have the
/// same rows, which begin with those of the columns themselves. Its values are a dense matrix, column by column. It is
/// CHOLMOD's own form, whose solves are in double precision only and go through all of L.
struct Supernodes {
    std::span<const int> first_column; ///< (S + 1)
    std::span<const int> row_start;    ///< (S + 1) index into row
    std::span<const int> row;
    std::span<const int> value_start; ///< (S + 1) index into the values
};

/// P A P^T = L L^T.
struct SupernodalFactor {
    Supernodes supernodes;
    std::span<const double> values; ///< of L
    std::span<const int> order;     ///< (n) of A, the row that each row of L is
};

/// x = L^-1 x. Supernodes that would multiply zeros alone are not read.
/// @param values  of L
/// @param x       shape (n, any)
template <class Scalar>
void solve_lower(const Supernodes &supernodes, std::span<const Scalar> values,
                 Eigen::Ref<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>> x);

/// x = L^-T x
template <class Scalar>
void solve_upper(const Supernodes &supernodes, std::span<const Scalar> values,
                 Eigen::Ref<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>> x);

struct SupernodalFactor;

/// Sparse Cholesky factor (CHOLMOD, supernodal), P A P^T = L L^T, ordered by nested dissection: of a solid that fills
/// half as much as minimum degree, and there is one ordering to find instead of the best of several. The same matrix
/// gives the same bits every time.
class SparseCholesky {
  public:
    /// The upper triangle of a symmetric matrix is read.
    using Matrix = Eigen::Ref<const Eigen::SparseMatrix<double>>;

    SparseCholesky();
    ~SparseCholesky();
    SparseCholesky(SparseCholesky &&) noexcept;
    SparseCholesky &operator=(SparseCholesky &&) noexcept;

    /// Finds an order for the unknowns, which serves all matrices with entries in the same places.
    /// @throws std::bad_alloc if there is too little memory
    void order(const Matrix &matrix);
    /// The same with a given order, from which only the tree of supernodes may differ.
    /// @param order  (n) of the matrix, the row that each row of L is
    void order(const Matrix &matrix, std::span<const int> order);
    /// Only after order(). Nothing is constrained then.
    /// @return whether the matrix is positive definite
    /// @throws std::bad_alloc if there is too little memory
    bool factorise(const Matrix &matrix);
    /// The square of the ratio of the smallest to the largest entry on the diagonal of L.
    double pivot_ratio() const;

    /// Keeps some unknowns at zero in all solutions to come, and clears what was constrained before: with E of their
    /// unit vectors, W = L^-1 P E and the projector Q = I - W (W^T W)^-1 W^T, the solution is P^T L^-T Q L^-1 P b. It
    /// is that of the matrix without their rows and columns, but takes no other factor.
    /// @param unknowns  each once; none to constrain nothing
    void constrain(std::vector<int> unknowns);

    /// Only after a factorise() that returned true.
    /// @param right_hand_sides  shape (n, any); what is constrained is not looked at
    Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd> &right_hand_sides) const;
    /// The same in single precision, for iterations that correct it: a solve waits for the factor to come from memory,
    /// and so takes half of the time. The first one keeps a copy of the factor.
    Eigen::MatrixXd solve_single_precision(const Eigen::Ref<const Eigen::MatrixXd> &right_hand_sides) const;

    /// L and P themselves, for solves of others. Only after a factorise() that returned true, and until the next one.
    SupernodalFactor factor() const;

    /// One of the two.
    using Solve = Eigen::MatrixXd (SparseCholesky::*)(const Eigen::Ref<const Eigen::MatrixXd> &) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Unknowns of a factor to constrain where it is to serve fewer than it has.
/// @param has   shape (n) whether each unknown of a larger system is one of the factor
/// @param free  shape (n) whether it is one of what is to be solved
/// @return nothing if the factor lacks one, or if there are so many to constrain that another factor
///   would take less time
std::optional<std::vector<int>> unknowns_to_constrain(const std::vector<bool> &has, const std::vector<bool> &free);

} // namespace livermark::support
