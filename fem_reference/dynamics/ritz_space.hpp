#pragma once

#include <Eigen/Core>

#include <functional>
#include <span>
#include <vector>

#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"

namespace livermark::fem_reference {

/// Load-dependent Ritz vectors: a space for the motion of a body on which a force r begins to act and stays,
///     x_1 = K^-1 r,   x_(j+1) = K^-1 M x_j,
/// each made orthonormal in the inner product of M to all before it. They are Lanczos's vectors of K^-1 M, cost one
/// solve each with one factor of K, and the first is the static solution to r. n is the number of nodes, m that of
/// vectors. (E. L. Wilson, M.-W. Yuan, J. M. Dickens 1982, Dynamic analysis by direct superposition of Ritz vectors,
/// Earthquake Eng. Struct. Dyn. 10(6); B. Nour-Omid, R. W. Clough 1984, Dynamic analysis of structures using Lanczos
/// co-ordinates, Earthquake Eng. Struct. Dyn. 12(4))
class RitzSpace {
  public:
    /// x = K^-1 f, and K x, with what is constrained at zero.
    /// @param f, x, k_x  shape (3 n)
    using SolveStatics = std::function<void(std::span<const double> f, std::span<double> x, std::span<double> k_x)>;

    /// An empty space of a stiffness that is there in its solutions only, as that of mixed elements is: their pressures
    /// are part of it.
    /// @param mass  kept alive by the caller
    RitzSpace(const SymmetricMatrix &mass, SolveStatics solve, std::vector<double> force);

    /// An empty space.
    /// @param stiffness  shape (3 n, 3 n) [N/m]
    /// @param mass       shape (n, n) [kg], of one component
    /// @param solver     of this stiffness, after a factorise() that returned true; the caller keeps it, the stiffness
    ///   and the mass alive
    /// @param force      r, shape (3 n) [N]; what acts on constrained unknowns does not count
    RitzSpace(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass, ConstrainedSolver &solver,
              std::vector<double> force);

    /// Adds a vector.
    /// @return false if there is no other: the motion lies in the space as it is
    bool extend();

    Eigen::Index size() const { return stiffness_of_space_.rows(); }
    /// V, shape (3 n, m) [kg^-1/2], zero where constrained: V^T M V = 1
    auto vectors() const { return vectors_.leftCols(size()); }
    /// V^T K V, shape (m, m) [s^-2]
    const Eigen::MatrixXd &stiffness() const { return stiffness_of_space_; }
    /// V^T r, shape (m) [N kg^-1/2]
    const Eigen::VectorXd &force() const { return force_on_space_; }

  private:
    void solve();
    bool make_orthogonal();

    const SymmetricBlocks<double> *stiffness_ = nullptr;
    const SymmetricMatrix &mass_;
    ConstrainedSolver *solver_ = nullptr;
    SolveStatics solve_statics_;
    std::vector<double> force_;
    std::vector<double> next_load_; ///< what K is solved for next
    std::vector<double> vector_, product_, force_of_vector_;
    Eigen::MatrixXd vectors_; ///< with columns to spare
    Eigen::MatrixXd forces_;  ///< K V where there is no stiffness to multiply by, with as many columns
    Eigen::MatrixXd stiffness_of_space_;
    Eigen::VectorXd force_on_space_;
};

} // namespace livermark::fem_reference
