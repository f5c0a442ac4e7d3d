#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace livermark::msm {

struct BoundedLeastSquares {
    Eigen::VectorXd x;  ///< (n) the minimiser; where the bound holds it back, the bound itself
    int num_solves = 0; ///< of sparse systems, by conjugate gradients
};

/// Sparse linear least squares with lower bounds: the x >= lower that minimises |A x - b|^2.
///
/// Block principal pivoting on the normal equations (Portugal, Judice, Vicente 1994, Math. Comp. 63(208); in this form
/// Kim, Park 2011, SIAM J. Sci. Comput. 33(6)): solve for the free unknowns, let every unknown change sides that is
/// below its bound, or at it and pushed inwards, and repeat. If that has not brought down their number in three goes,
/// only the last of them changes sides (Murty's rule), which ends for every positive definite A^T A. At the end the
/// conditions of Karush, Kuhn and Tucker hold to 1e-10 of the size of the problem: with columns of length one, no
/// gradient A^T (A x - b) points below zero, nor off it where x is free, by more than that part of |b - A lower|.
/// The same input gives the same x on one machine.
/// Of columns that depend on each other there are several minimisers, and this is one.
/// @param matrix  A, shape (m, n), no column zero
/// @param target  b, shape (m)
/// @param lower   shape (n), finite
/// @throws std::invalid_argument if the shapes differ, or if a column is zero or not finite
/// @throws std::runtime_error    if the columns depend on each other so nearly that no minimiser is found
BoundedLeastSquares solve_bounded_least_squares(const Eigen::SparseMatrix<double> &matrix,
                                                const Eigen::VectorXd &target, const Eigen::VectorXd &lower);

} // namespace livermark::msm
