#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"

namespace livermark::experiments {

/// How a place moved, as a polynomial of two coordinates along it: the least-squares fit to markers on it. Each
/// component of the displacement is sum c_ab s^a t^b over a + b <= degree, with s and t along the two longest principal
/// axes of the markers, in units of their spread.
class FittedMotion {
  public:
    /// @param positions      of the markers at rest [m]
    /// @param displacements  of the same markers [m]
    /// @param degree         >= 0
    /// @param place          named in messages
    /// @throws support::InputError if the markers do not determine the polynomial
    FittedMotion(std::span<const core::Vector3> positions, std::span<const core::Vector3> displacements, int degree,
                 const std::string &place);

    /// Displacement at a point [m].
    core::Vector3 at(const core::Vector3 &point) const;

    /// Root mean square distance between the polynomial and the markers [m].
    double residual() const { return residual_; }

    /// Centroid of the markers [m].
    const core::Vector3 &middle() const { return middle_; }

  private:
    Eigen::RowVectorXd monomials(const core::Vector3 &point) const;

    int degree_;
    core::Vector3 middle_;
    Eigen::Matrix<double, 2, 3> axes_; ///< divided by the spread along them [1/m]
    Eigen::MatrixX3d coefficients_;    ///< [m]
    double residual_ = 0.0;
};

/// A patch and how it moves.
struct PlaceMotion {
    std::string patch;
    FittedMotion motion;
};

/// Lets a constrained patch move: adds to the displacement of its nodes.
/// @throws support::InputError if the body has no such patch or it is not constrained
void drive(core::LoadCase &load_case, const core::TetraMesh &mesh, const PlaceMotion &place);

/// The displacement that is linear between two places that move: what no mechanics at all gives.
core::Vector3 straight_line(const PlaceMotion &from, const PlaceMotion &to, const core::Vector3 &point);

/// x -> rotation (x - from) + to.
struct RigidMotion {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    core::Vector3 from = core::Vector3::Zero(), to = core::Vector3::Zero(); ///< [m]

    core::Vector3 at(const core::Vector3 &point) const { return rotation * (point - from) + to; }
};

/// The rigid motion of least sum |x' - y|^2 over points x that it takes to x' (Kabsch 1976, Acta Cryst. A32).
/// @param points   x, at least one [m]
/// @param targets  y [m]
RigidMotion best_rigid_motion(std::span<const core::Vector3> points, std::span<const core::Vector3> targets);

} // namespace livermark::experiments
