#pragma once

#include "core/load_case.hpp"
#include "fem_reference/dynamics/ritz_space.hpp"

namespace livermark::fem_reference {

/// What Newmark's average acceleration, as in Newmark, makes of M z'' + D z' + K z = r in a space of m vectors, from
/// z = 0 and rest: M is the identity there, and D is Rayleigh damping, so that the modes of the space move each for
/// itself.
class RitzMotion {
  public:
    /// @param stiffness  V^T K V, shape (m, m) [s^-2]
    /// @param force      V^T r, shape (m) [N kg^-1/2]
    /// @param time_step  [s], > 0
    RitzMotion(const Eigen::MatrixXd &stiffness, const Eigen::VectorXd &force, const core::RayleighDamping &damping,
               double time_step);

    /// Moves on by one step.
    void advance();

    /// q, shape (m) [m kg^1/2]: z = V q
    Eigen::VectorXd displacement() const { return modes_ * displacement_.matrix(); }
    /// dq/dt, shape (m) [m/s kg^1/2]: the kinetic energy is half its square
    Eigen::VectorXd velocity() const { return modes_ * velocity_.matrix(); }

  private:
    double time_step_;
    Eigen::MatrixXd modes_;
    Eigen::ArrayXd square_;    ///< of their angular frequencies
    Eigen::ArrayXd force_;     ///< on each
    Eigen::ArrayXd effective_; ///< 2 / h + alpha + (beta + h / 2) omega^2
    Eigen::ArrayXd displacement_, velocity_;
};

/// The motion after a release in the first vectors of a space.
RitzMotion motion_in(const RitzSpace &space, Eigen::Index num_vectors, const core::Release &release);

/// Extends a space until it holds the motion after a release: until the motion of the whole body (in the norm of M) and
/// that of each probe change by less than 5e-5 (relative L2 in time) with the last ten vectors. That is what the space
/// lacked before it had them; with them the livers, damped by 5 %, are within 3e-5 of steps of the whole body.
/// @param space  of the force that is out of balance where the motion starts
/// @return false where steps of the whole body come cheaper, because the space would have to have more than half as
///   many vectors as there are steps. Weak damping does that.
bool extend_until_converged(RitzSpace &space, const core::Release &release);

} // namespace livermark::fem_reference
