#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "msm/cholesky.hpp"
#include "msm/elastic_body.hpp"
#include "msm/free_components.hpp"

namespace livermark::msm {

/// The stiffness of a body at rest, and its factor on the components that are free. Load cases that hold the same
/// components share one.
class RestStiffness {
  public:
    /// @param positions   shape (N) of rest [m]
    /// @param prescribed  shape (N) displacement [m], NaN where a component is free; the values do not matter
    RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                  const std::vector<core::Vector3> &prescribed);
    /// The same where the stiffness is there already: it does not depend on what is held.
    /// @param stiffness   (3N, 3N) elastic_hessian() at rest, exact [N/m]
    RestStiffness(std::shared_ptr<const Eigen::SparseMatrix<double>> stiffness,
                  const std::vector<core::Vector3> &positions, const std::vector<core::Vector3> &prescribed);

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
    std::shared_ptr<const Eigen::SparseMatrix<double>> stiffness_; // (3N, 3N)
    Cholesky factor_;
    bool is_definite_ = false;
    double rounding_force_ = 0.0;
};

} // namespace livermark::msm
