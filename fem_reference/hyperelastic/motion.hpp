#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/rayleigh_damping.hpp"
#include "core/solution.hpp"
#include "core/tool/tool_motion.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/hyperelastic/surface.hpp"

namespace livermark::hyperelastic {

/// Steps in time of a hyperelastic body by the energy-momentum method, for M u'' + alpha M u' + f(u, u') = l with
/// consistent mass and loads that do not change: with v_m = (u_1 - u_0) / h, the mean of the velocities before and
/// after a step of length h, it is
///     2 M (v_m - v_0) / h + alpha M v_m + f(u_0, u_1) = l,   v_1 = 2 v_m - v_0,
/// with the forces f of MotionForces. It is of second order, and at small strain fem_reference::Newmark. Without
/// damping it conserves the energy 1/2 v^T M v + W(u) - l^T u, with damping it loses some in each step, whatever the
/// length.
///
/// Each step is solved by Newton's method with a factor of the tangent that is kept as long as it serves, and
/// Anderson's acceleration, which makes up for what the kept tangent lacks. (D. G. Anderson 1965, Iterative procedures
/// for nonlinear integral equations, J. ACM 12(4); H. Walker, P. Ni 2011, SIAM J. Numer. Anal. 49(4))
///
/// A ball that touches the body exerts what it does half way: where the mean of the displacements before and after the
/// step meets the mean of its places. That keeps the momentum, and is of second order. Its pressures are multipliers of
/// the next step, so that it hardly sinks in, and its friction goes from step to step.
///
/// n is the number of nodes.
class EnergyMomentum {
  public:
    /// @param elements   in displacements alone; kept alive by the caller
    /// @param rule       that they were made with
    /// @param is_free    shape (3 n); the others stay where the motion starts, or go to their targets
    /// @param damping    alpha and beta not negative
    /// @param force      that is of the order of what is at work [N]
    /// @param tolerance  what may be left out of balance, over that force
    EnergyMomentum(const Elements &elements, TetrahedronRule rule, const std::vector<bool> &is_free,
                   const core::RayleighDamping &damping, double force, double tolerance = 1e-7);
    ~EnergyMomentum();
    EnergyMomentum(EnergyMomentum &&) noexcept;
    EnergyMomentum &operator=(EnergyMomentum &&) noexcept;

    /// Place of a touching ball before and after a step [m].
    struct BallStep {
        core::Vector3 from, to;
    };

    /// The ball that touches from now on, kept alive by the caller; or nullptr.
    void touch_with(TouchingBall *ball);
    /// Force that it exerts on the body at the end of the last step, on the line through what it did half way through
    /// the last two [N].
    core::Vector3 force_of_ball() const;

    /// Moves on by one step, which is taken in halves where it does not converge.
    /// @param load       l, shape (3 n) [N]
    /// @param time_step  h [s], > 0
    /// @param target     shape (3 n) [m]: where what is not free is at the end of the step; empty if it stays
    /// @param ball       of the ball, if there is one
    /// @return false if even the shortest of these steps does not converge; the motion is then where it came to
    bool advance(fem_reference::Motion &motion, std::span<const double> load, double time_step,
                 std::span<const double> target = {}, const BallStep &ball = {});

    /// Kinetic and strain energy.
    fem_reference::Energy energy(const fem_reference::Motion &motion);

    /// Sum over all steps so far.
    struct Work {
        int steps = 0, iterations = 0, factors = 0;
    };
    Work work() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Result of release().
struct ReleasedBody {
    core::History history;
    EnergyMomentum::Work work;
};

/// Lets all tractions of a load case go at t = 0, also pressures that follow the surface, and follows the body from
/// rest with EnergyMomentum, a step per output interval.
/// @param elements      in displacements alone
/// @param rule          that they were made with
/// @param load_case     of the body's mesh, with its release
/// @param displacement  where it starts, shape (3 n) [m]
/// @return of a motion that finds no next step, the records from then on are NaN, and diverged_at says when
/// @throws std::invalid_argument for mixed elements
/// @throws std::runtime_error if the memory does not hold a factor
ReleasedBody release(const Elements &elements, TetrahedronRule rule, const core::LoadCase &load_case,
                     std::vector<double> displacement);

/// Follows a body that a tool moves with EnergyMomentum, from rest.
/// @param problem          of a load case with a tool
/// @param degree           1 or 2, of elements in displacements alone
/// @param steps_per_frame  >= 1
/// @return the records as far as the motion came: fewer than all where it finds no next step
/// @throws std::invalid_argument for a load case without a tool, and elements that do not exist
/// @throws std::runtime_error if the memory does not hold a factor
core::ToolHistory move_tool(const core::Problem &problem, const MaterialLaw &law, int degree, int steps_per_frame,
                            TetrahedronRule rule = TetrahedronRule::fourteen_points);

} // namespace livermark::hyperelastic
