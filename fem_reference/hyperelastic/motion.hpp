#pragma once

#include <Eigen/Core>
#include <array>
#include <deque>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/relaxation.hpp"
#include "core/solution.hpp"
#include "core/tool/tool_motion.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/hyperelastic/surface.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::hyperelastic {

/// The matrix m M + k K of an implicit step on what is free, with the consistent mass M and the tangent stiffness K of
/// a state, and its sparse Cholesky factor (CHOLMOD). n is the number of nodes.
class EffectiveMass {
  public:
    /// @param elements  in displacements alone; kept alive by the caller
    /// @param is_free   shape (3 n)
    EffectiveMass(const Elements &elements, std::vector<bool> is_free);

    /// out = M x
    /// @param x, out  shape (3 n)
    void multiply_mass(std::span<const double> x, std::span<double> out) const;

    /// Factors m M + k K. Where that is not positive definite, because the state is unstable, K is that at rest.
    /// @param displacement  of the state, shape (3 n) [m], without an element inside out
    /// @param surface       whose symmetric parts K gets, too
    void factorise(double m, double k, const std::vector<double> &displacement, const SurfaceStiffness &surface = {});

    /// (m M + k K) x = b with the last factor, in single precision: for iterations that correct it.
    /// @param b, x  shape (3 n); what is not free does not count, and is zero
    void solve(std::span<const double> b, std::span<double> x) const;

  private:
    bool factorise(double m, double k);

    const Elements *elements_;
    fem_reference::SymmetricMatrix mass_; ///< (n, n), of one component
    TangentMatrices tangent_;
    fem_reference::BlockFactor factor_;
};

/// Internal forces of a step in time by the energy-momentum method. Between displacements u_0 and u_1, a step of length
/// h apart, they do the work by which the energy changes, but for what viscosity takes:
///     f_a = integral of F_m (S + beta (S_1 - S_0) / h) grad N_a,   F_m = (F_0 + F_1) / 2,
///     S = S(C_m) + 2 (W_1 - W_0 - S(C_m) : dC / 2) dC / (dC : dC),   C_m = (C_0 + C_1) / 2,   dC = C_1 - C_0,
/// with the second Piola-Kirchhoff stress S = 2 dW/dC. The stress S changes with squared lengths only, so rigid motions
/// are free of viscous forces, and momentum and angular momentum do not change.
/// (O. Gonzalez 2000, Exact energy and momentum conserving algorithms for general models in nonlinear elasticity,
/// Comput. Methods Appl. Mech. Engrg. 190, eq. 43; J. C. Simo, N. Tarnow 1992, The discrete energy-momentum method,
/// Z. angew. Math. Phys. 43; the viscosity is Kelvin's and Voigt's, and at small strain Rayleigh's beta K)
///
/// n is the number of nodes.
class MotionForces {
  public:
    /// @param elements   in displacements alone; kept alive by the caller
    /// @param rule       that they were made with
    /// @param viscosity  beta [s], >= 0
    /// @throws std::invalid_argument for mixed elements
    MotionForces(const Elements &elements, TetrahedronRule rule, double viscosity);

    /// Sets where a step begins.
    /// @param displacement  u_0, shape (3 n) [m], without an element inside out
    /// @return strain energy there [J]
    double begin_at(std::span<const double> displacement);

    /// End of a step.
    struct AtEnd {
        bool is_possible = false;  ///< no element is inside out; otherwise nothing else is set
        double energy = 0.0;       ///< strain energy at u_1 [J]
        std::vector<double> force; ///< (3 n) f [N]
    };
    /// @param displacement  u_1, shape (3 n) [m]
    /// @param time_step     h [s], > 0
    void end_at(std::span<const double> displacement, double time_step, AtEnd &result) const;

  private:
    /// State of a point of integration where the step begins.
    struct Point {
        Matrix3 deformation; ///< F_0
        Matrix3 stress;      ///< S_0 [Pa]
        double energy;       ///< W_0 [Pa]
    };
    template <int nodes> double begin(std::span<const double> displacement);
    template <int nodes> void end(std::span<const double> displacement, double time_step, AtEnd &result) const;

    const Elements *elements_;
    ReferenceTetrahedron reference_;
    double viscosity_;
    std::vector<Matrix3> inverse_edges_; ///< (M) of the matrix of the edges from the first corner [1/m]
    std::vector<double> volume_;         ///< (M) [m^3]
    std::vector<Point> start_;           ///< (M, Q)
};

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

    /// Place of a touching ball before and after a step [m].
    struct BallStep {
        core::Vector3 from, to;
    };

    /// The ball that touches from now on, kept alive by the caller; or nullptr.
    void touch_with(TouchingBall *ball);
    /// Force that it exerts on the body at the end of the last step, on the line through what it did half way through
    /// the last two [N].
    core::Vector3 force_of_ball() const { return 1.5 * ball_force_[1] - 0.5 * ball_force_[0]; }

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
    Work work() const { return work_; }

  private:
    using Unknowns = Eigen::VectorXd;
    double begin_at(const std::vector<double> &displacement);
    bool step(fem_reference::Motion &motion, std::span<const double> load, double time_step,
              std::span<const double> target, const BallStep &way);
    bool advance(fem_reference::Motion &motion, std::span<const double> load, double time_step,
                 std::span<const double> target, const BallStep &way, int halvings);
    Unknowns first_guess(const fem_reference::Motion &motion, double time_step) const;
    void factorise(const fem_reference::Motion &motion, double time_step, const core::Vector3 &ball_centre);

    std::vector<bool> is_free_;
    core::RayleighDamping damping_;
    double largest_residual_; ///< [N]
    MotionForces forces_;
    EffectiveMass mass_;
    MotionForces::AtEnd at_end_;
    TouchingBall *ball_ = nullptr;
    /// Half way through the last two steps [N].
    std::array<core::Vector3, 2> ball_force_{core::Vector3::Zero(), core::Vector3::Zero()};
    std::vector<double> begun_at_; ///< where the forces have begun a step last
    double strain_energy_ = 0.0;   ///< there [J]
    double factored_step_ = 0.0;   ///< that the factor is for [s]; zero if there is none
    int fewest_iterations_ = -1;   ///< of the first step with the factor, negative before
    int excess_iterations_ = 0;    ///< beyond these, of all steps with it
    /// The last displacements, the newest behind, all a step of the same length apart.
    std::deque<Unknowns> before_;
    double step_before_ = 0.0;
    Work work_;
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
