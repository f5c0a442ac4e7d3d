#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// Which of the 3N displacement components are unknown, and their numbers among the unknowns.
class FreeComponents {
  public:
    explicit FreeComponents(const std::vector<core::Vector3> &prescribed);
    bool operator==(const FreeComponents &) const = default;

    Eigen::Index size() const { return size_; }
    /// Number of a component among the unknowns, -1 where it is prescribed.
    Eigen::Index number(Eigen::Index component) const { return number_[component]; }
    bool is_free(Eigen::Index component) const { return number_[component] >= 0; }
    /// Of all components, shape (3N).
    std::vector<bool> are_free() const;

    /// The free components of a nodal field.
    Eigen::VectorXd gather(const std::vector<core::Vector3> &field) const;
    /// Adds scale * values to the free components of a nodal field.
    void add(std::vector<core::Vector3> &field, const Eigen::VectorXd &values, double scale) const;
    /// Rows and columns of the free components.
    Eigen::SparseMatrix<double> restrict(const Eigen::SparseMatrix<double> &matrix) const;

  private:
    std::vector<Eigen::Index> number_; // (3N) number among the unknowns, -1 where prescribed
    Eigen::Index size_ = 0;
};

/// m^-1/2 of every free component.
/// @param node_mass  shape (N) [kg], > 0
/// @return shape (free.size()) [kg^-1/2]
Eigen::VectorXd inverse_root_mass(const std::vector<double> &node_mass, const FreeComponents &free);

} // namespace livermark::msm
