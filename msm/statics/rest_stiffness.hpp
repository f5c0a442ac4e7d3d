#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <vector>

#include "msm/elastic_body.hpp"
#include "msm/statics/free_components.hpp"
#include "msm/statics/limited_memory.hpp"
#include "support/factors/sparse_cholesky.hpp"

namespace livermark::msm {

/// The stiffness of a body at rest, and its factor on the components that are free. Load cases that constrain the same
/// components share one, and those that constrain few more than a common part one of that. Of a body with a
/// preconditioner the factor is that of the preconditioner's stiffness, and the linear answer is found by conjugate
/// gradients.
class RestStiffness {
  public:
    /// Constrains nothing yet.
    /// @param positions   shape (N) of rest [m]
    /// @param common      shape (N) as for constrain(), what more than one of the load cases to come constrain, maybe
    /// among more;
    ///                    empty if there is no such thing
    static RestStiffness of_many(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                 std::vector<core::Vector3> common);
    /// Of a single set of constrained components.
    /// @param positions   shape (N) of rest [m]
    /// @param prescribed  see constrain()
    RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                  const std::vector<core::Vector3> &prescribed);

    /// Factors, unless the same components are constrained.
    /// @param prescribed  shape (N) displacement [m], NaN where a component is free; the values do not matter
    void constrain(const std::vector<core::Vector3> &prescribed);
    /// Whether the same components are constrained.
    bool constrains(const std::vector<core::Vector3> &prescribed) const;
    const FreeComponents &free() const { return free_; }
    /// If not, the body is not stiff in every direction and there is no factor.
    bool is_definite() const { return is_definite_; }
    /// Whether the factor is only near that of the body.
    bool is_approximate() const { return product_.has_value(); }
    /// K_ff^-1 f_f in single precision, see support::SparseCholesky::solve_single_precision(), only if it is definite.
    /// @param force  shape (free().size())
    Eigen::VectorXd inverse_times(const Eigen::VectorXd &force) const;
    /// Seconds that what is in use took, also when it was made for an earlier load case.
    double factor_seconds() const { return factor_seconds_ + constrain_seconds_; }
    /// The forces that the last digit of the positions makes [N].
    double rounding_force() const { return rounding_force_; }
    /// Solution of the linear body: K_ff u_f = f_f - K_fc u_c, to rounding or, where the factor is approximate, to
    /// 1e-10 of the load.
    /// @param force  shape (N) [N]
    /// @param memory  learns from the steps of conjugate gradients, if there are any
    /// @return shape (N) [m]; where it is not definite, the prescribed displacements alone
    std::vector<core::Vector3> solve(const std::vector<core::Vector3> &prescribed,
                                     const std::vector<core::Vector3> &force, LimitedMemory *memory = nullptr) const;

  private:
    RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions);
    Eigen::VectorXd product(const Eigen::VectorXd &displacement) const;
    Eigen::VectorXd by_conjugate_gradients(const Eigen::VectorXd &load, LimitedMemory *memory) const;
    bool factorise(const FreeComponents &rows);
    Eigen::VectorXd inverse_times(const Eigen::VectorXd &force, support::SparseCholesky::Solve solve) const;

    Eigen::SparseMatrix<double> stiffness_;   // (3N, 3N) of the body or its preconditioner
    std::optional<StiffnessProduct> product_; // of the body, if the matrix is not
    Eigen::VectorXd diagonal_;                // (3N) of the body [N/m]
    double extent_ = 0.0;                     // [m]
    std::vector<core::Vector3> common_;       // (N), or empty
    FreeComponents free_{{}};                 // of what is constrained now
    std::optional<FreeComponents> rows_;      // of the factor: the same, or more; none if there is no factor
    support::SparseCholesky factor_;
    bool rows_are_definite_ = false;
    bool is_definite_ = false;
    double rounding_force_ = 0.0;
    double factor_seconds_ = 0.0;
    double constrain_seconds_ = 0.0;
};

} // namespace livermark::msm
