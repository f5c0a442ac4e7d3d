#pragma once

#include <Eigen/Core>
#include <functional>

namespace livermark::msm {

/// A linear map that nobody has to write down.
using LinearMap = std::function<Eigen::VectorXd(const Eigen::VectorXd &)>;

/// A x = b by preconditioned conjugate gradients, in the flexible form of Golub and Ye 1999 (SIAM J. Sci. Comput. 21):
/// an inverse in single precision is a little different each time.
/// @param matrix     A, symmetric, of any size n
/// @param inverse    near A^-1, positive definite
/// @param tolerance  of |b - A x| over |b|
/// @param see        is shown each step and A times it
/// @return x of shape (n), or where it came to after the last step. Where a direction d bends downwards, d^T A d <= 0,
/// it
///   is what was found before, or d if that was the first one (Steihaug 1983, SIAM J. Numer. Anal. 20): downhill in
///   x^T A x / 2 - b^T x either way.
Eigen::VectorXd
conjugate_gradients(const LinearMap &matrix, const LinearMap &inverse, const Eigen::VectorXd &b, double tolerance,
                    int max_steps,
                    const std::function<void(const Eigen::VectorXd &, const Eigen::VectorXd &)> &see = {});

} // namespace livermark::msm
