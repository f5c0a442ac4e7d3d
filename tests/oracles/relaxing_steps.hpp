#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "core/load_case.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"

namespace livermark::tests {

/// Explicit steps of point masses on springs that relax, the slow and obvious ones: with the stresses that
/// RelaxingBody has at x,
///   v(n+1) = v(n) + h M^-1 (f + F(x(n)) - alpha M v(n) + dashpots of beta),   x(n+1) = x(n) + h v(n+1),
/// symplectic Euler as in elastic_motion(), and then the branches go on to x(n+1) exactly.
///
/// A step that is stable without branches is stable with them, however short their times are. Of a mode with omega^2 on
/// relaxing springs alone, the step has the characteristic equation
///   (z - 1)^2 / z + (omega h)^2 H(z) = 0,   H(z) = remaining() + sum over branches of gain (z - 1) / (z - fade).
/// H on the unit circle has an imaginary part of one sign, gain (1 - fade) sin(angle) over a square, so nothing is fed
/// in, and at z = -1, where a step ends to be stable, a branch is worth g 2 / x tanh(x / 2) <= g with x = h / tau.
///
/// If velocities start half a step before positions, these are leapfrog steps, and positions of second order.
class RelaxingSteps {
  public:
    /// @param body        with what its branches have borne before it starts
    /// @param positions   shape (N) [m], where the body is at rest
    /// @param conditions  loads, and which components are constrained; these stay where they start
    /// @param time_step   h [s], > 0
    RelaxingSteps(msm::RelaxingBody body, const std::vector<core::Vector3> &positions,
                  const msm::NodalConditions &conditions, const core::RayleighDamping &damping, double time_step)
        : body_(std::move(body)), rest_(msm::to_unknowns(positions)), load_(msm::to_unknowns(conditions.force)),
          free_(rest_.size()), free_per_mass_(rest_.size()), damping_(damping), time_step_(time_step) {
        for (std::size_t i = 0; i < positions.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                const auto at = 3 * static_cast<Eigen::Index>(i) + c;
                free_[at] = std::isnan(conditions.displacement[i][c]) ? 1.0 : 0.0;
                free_per_mass_[at] = free_[at] / body_.instant().node_mass[i];
            }
    }

    /// Takes that many steps.
    /// @param state  of which the displacement is where the body went on to last
    void take(msm::State &state, int num_steps) {
        auto &[displacement, velocity] = state;
        Eigen::VectorXd x = rest_ + displacement, force;
        for (int s = 0; s < num_steps; ++s) {
            force = load_;
            body_.add_force(x, velocity, damping_.beta, force);
            velocity +=
                time_step_ * (force.cwiseProduct(free_per_mass_) - damping_.alpha * velocity.cwiseProduct(free_));
            displacement += time_step_ * velocity;
            x = rest_ + displacement;
            body_.go_on(x, time_step_);
        }
    }

    const msm::RelaxingBody &body() const { return body_; }

  private:
    msm::RelaxingBody body_;
    Eigen::VectorXd rest_, load_, free_, free_per_mass_; // (3N)
    core::RayleighDamping damping_;
    double time_step_;
};

} // namespace livermark::tests
