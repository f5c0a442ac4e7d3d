#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "msm/elastic_body.hpp"
#include "msm/free_components.hpp"

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

/// The stiffness of a body at rest, and its factor on the components that are free. Load cases that hold the same
/// components share one.
class RestStiffness {
  public:
    /// @param positions   shape (N) of rest [m]
    /// @param prescribed  shape (N) displacement [m], NaN where a component is free; the values do not matter
    RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                  const std::vector<core::Vector3> &prescribed);

    /// Whether the same components are held.
    bool holds(const std::vector<core::Vector3> &prescribed) const;
    const FreeComponents &free() const { return free_; }
    /// If not, the body is not stiff in every direction and there is no factor.
    bool is_definite() const { return is_definite_; }
    const Cholesky &factor() const { return factor_; }
    /// The forces that the last digit of the positions makes [N].
    double rounding_force() const { return rounding_force_; }
    /// Answer of the linear body: K_ff u_f = f_f - K_fc u_c.
    /// @param force  shape (N) [N]
    /// @return shape (N) [m]; where it is not definite, the prescribed displacements alone
    std::vector<core::Vector3> solve(const std::vector<core::Vector3> &prescribed,
                                     const std::vector<core::Vector3> &force) const;

  private:
    FreeComponents free_;
    Eigen::SparseMatrix<double> stiffness_; // (3N, 3N)
    Cholesky factor_;
    bool is_definite_ = false;
    double rounding_force_ = 0.0;
};

} // namespace livermark::msm
