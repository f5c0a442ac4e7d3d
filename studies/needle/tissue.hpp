#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <map>
#include <optional>

#include "core/tool/needle/needle.hpp"
#include "core/tool/needle/pushed_body.hpp"

namespace livermark::studies {

/// By which a place gives way against the needle [m/N].
inline constexpr double place_softness = 1.0 / core::needle_stiffness;

/// A body along the axis of a needle and across it, as if it were linear from where it was pushed to last: u = b + C f.
/// The K components along the axis come first, then the 2 K across it. C begins with that of the body at rest; what the
/// body does under other forces corrects b, so that the model is exact there, and C by the formula of Broyden,
/// Fletcher, Goldfarb and Shanno for an inverse, which makes it exact for the last change of forces (J. Nocedal, S. J.
/// Wright 2006, Numerical Optimization, eq. 6.17).
class Tissue {
  public:
    /// @param body  kept alive by the caller
    Tissue(core::PushedBody &body, const core::Vector3 &axis);

    /// With the first places held across.
    struct Held {
        Eigen::MatrixXd along;              ///< (K, K) displacement along the axis for forces along it [m/N]
        Eigen::MatrixXd of_hold;            ///< (K, 2 h) the same for displacements across, at which places are held
        Eigen::LLT<Eigen::MatrixXd> across; ///< of what is held
    };
    const Held &held(Eigen::Index count);

    /// Displacement along the axis without forces along it.
    /// @param hold  (2 h) displacements across, at which places are held [m]
    /// @return (K) [m]
    Eigen::VectorXd along_without_forces(const Eigen::VectorXd &hold);
    /// @param along  (K) forces along the axis [N]
    /// @return (2 h) what holds the places [N]
    Eigen::VectorXd forces_across(const Eigen::VectorXd &along, const Eigen::VectorXd &hold);
    /// @param across  (2 h) forces across it [N]
    /// @return (2 K) [m]
    Eigen::VectorXd displacement_across(const Eigen::VectorXd &along, const Eigen::VectorXd &across) const;
    core::Vector3 in_space(double along, double across_1, double across_2) const;
    Eigen::Index size() const { return size_; } ///< K

    /// Pushes the body itself, and corrects the model where it was wrong by more than a tolerance.
    /// @param along, across  (K), (2 h) forces [N]
    /// @return by how much a place was elsewhere than the model said [m]; nothing if the body comes to no rest
    std::optional<double> push(const Eigen::VectorXd &along, const Eigen::VectorXd &across, double tolerance);
    /// What the body stores under forces near those that it was pushed with last: what it stored then, and the work on
    /// the way from there, as the model has it [J].
    double stored(const Eigen::VectorXd &along, const Eigen::VectorXd &across) const;

  private:
    Eigen::VectorXd joined(const Eigen::VectorXd &along, const Eigen::VectorXd &across) const;
    void learn(const Eigen::VectorXd &force, const Eigen::VectorXd &displacement);

    core::PushedBody &body_;
    Eigen::Matrix3d frame_; ///< rows: the axis, and two directions across it
    Eigen::Index size_;
    Eigen::MatrixXd compliance_;                         ///< (3 K, 3 K) C [m/N]
    Eigen::VectorXd offset_;                             ///< (3 K) b [m]
    Eigen::VectorXd pushed_force_, pushed_displacement_; ///< (3 K) where the body itself was last
    double pushed_stored_ = 0.0;                         ///< [J]
    std::map<Eigen::Index, Held> held_;
};

} // namespace livermark::studies
