#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace Teuchos {
class ParameterList;
}

namespace livermark::fem_reference {

/// The motions that strain nothing, linearised: three translations, then three rotations about the middle of a body,
/// over its size.
class RigidModes {
  public:
    static constexpr int count = 6;

    /// @param points  of the body [m]; at least two different ones
    explicit RigidModes(std::span<const core::Vector3> points);

    /// Values of the modes (columns) at a point, by components (rows).
    Eigen::Matrix<double, 3, count> at(const core::Vector3 &point) const;

  private:
    core::Vector3 middle_; // [m]
    double size_;          // [m]
};

/// Puts columns in balance: moves all that is free of each by a rigid motion, so that the residual that is left there
/// has neither a resultant nor a moment, and reactions balance the loads. With Z the rigid modes, zero where
/// constrained, u_c
/// += Z (Z^T K Z)^-1 Z^T r_c, which also takes u_c as near to K^-1 f_c as such a motion can, in the norm of the energy
/// (Galerkin). As K R = 0 for the modes R of all unknowns, Z^T K Z = R_h^T K_hh R_h, with what is constrained alone.
/// @param free      in all of its sets what is constrained stops every rigid motion
/// @param residual  shape (n, lanes), see matrices.hpp, r = f - K u where free, zero where constrained
/// @param u         shape (n, lanes)
void balance(const ElasticSystem &system, const FreeUnknowns &free, std::span<const double> residual,
             std::span<double> u);

/// Settings by which Trilinos ML makes and applies the levels of a smoothed aggregation multigrid for elasticity.
/// @param modes  (6, n) rigid body modes at the n unknowns of this rank, the near-nullspace; the list points to them
///               and they are read while the levels are made
Teuchos::ParameterList multigrid_settings(std::vector<double> &modes);

/// Smoothed aggregation multigrid (Trilinos ML) with the six rigid body modes as near-nullspace.
/// @param system  kept alive and unchanged by the caller
std::unique_ptr<Preconditioner> algebraic_multigrid(const ElasticSystem &system);

} // namespace livermark::fem_reference
