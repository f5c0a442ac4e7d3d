#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>

namespace livermark::msm {

/// Where n unknowns are and how they move.
struct State {
    Eigen::VectorXd displacement; ///< (n) u [m]
    Eigen::VectorXd velocity;     ///< (n) v [m/s]
};

/// M u'' = F(u, u') with a diagonal M. Unknowns that are constrained have no acceleration, and nothing moves them.
struct EquationOfMotion {
    Eigen::VectorXd mass; ///< (n) diagonal of M [kg]
    /// a = M^-1 F(u, v), shape (n) [m/s^2]; the third argument has its size
    std::function<void(const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a)> acceleration;
    /// M + d D + k K with D = -dF/dv and K = -dF/du at (u, 0), or a positive definite matrix close to it; the rows and
    /// columns of constrained unknowns are those of M. Asked for by implicit integrators only.
    std::function<Eigen::SparseMatrix<double>(const Eigen::VectorXd &u, double d, double k)> effective_mass;
};

} // namespace livermark::msm
