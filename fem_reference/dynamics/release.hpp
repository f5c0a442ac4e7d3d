#pragma once

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/load_case.hpp"
#include "core/solution.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

/// Positions and velocities of all unknowns; n is the number of nodes.
struct Motion {
    std::vector<double> displacement; ///< (3 n) u [m]
    std::vector<double> velocity;     ///< (3 n) v [m/s]
};

/// Energies of a motion.
struct Energy {
    double kinetic = 0.0; ///< 1/2 v^T M v [J]
    double strain = 0.0;  ///< 1/2 u^T K u [J]
};

/// Newmark's average acceleration (gamma = 1/2, beta = 1/4) for M u'' + D u' + K u = f with Rayleigh damping,
/// consistent mass and loads that do not change. With v_m the mean of the velocities before and after a step of length
/// h, it is
///     (2 M / h + D + h K / 2) v_m = 2 M v / h + f - K u,   u <- u + h v_m,   v <- 2 v_m - v,
/// which needs no accelerations and one solve. It is of second order, stable for every h, and without damping conserves
/// 1/2 v^T M v + 1/2 u^T K u - f^T u.
/// (N. M. Newmark 1959, A method of computation for structural dynamics, J. Eng. Mech. Div. 85(3))
///
/// The matrix on the left is factored once.
class Newmark {
  public:
    /// @param stiffness   shape (3 n, 3 n) [N/m]; the caller keeps it alive and unchanged
    /// @param mass        shape (n, n) [kg], of one component, as consistent_mass gives it; kept alive as well
    /// @param damping     alpha and beta not negative
    /// @param time_step   h [s], > 0
    /// @param prescribed  shape (3 n), NaN where an unknown is free; the others stay where the motion starts
    /// @throws std::runtime_error if the memory does not hold the factor
    Newmark(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass, const core::RayleighDamping &damping,
            double time_step, std::span<const double> prescribed);

    /// Moves on by one step.
    /// @param motion  velocity zero where prescribed
    /// @param load    f, shape (3 n) [N]
    /// @return the energies before the step, which are a by-product of it
    Energy advance(Motion &motion, std::span<const double> load);

    Energy energy(const Motion &motion);

  private:
    const SymmetricBlocks<double> *stiffness_;
    const SymmetricMatrix *mass_;
    double time_step_;
    ConstrainedSolver solver_;
    std::vector<double> force_, momentum_, mean_velocity_;
};

/// Load-dependent Ritz vectors: a space for the motion of a body on which a force r begins to act and stays,
///     x_1 = K^-1 r,   x_(j+1) = K^-1 M x_j,
/// each made orthonormal in the inner product of M to all before it. They are Lanczos's vectors of K^-1 M, cost one
/// solve each with one factor of K, and the first is the static solution to r. n is the number of nodes, m that of
/// vectors. (E. L. Wilson, M.-W. Yuan, J. M. Dickens 1982, Dynamic analysis by direct superposition of Ritz vectors,
/// Earthquake Eng. Struct. Dyn. 10(6); B. Nour-Omid, R. W. Clough 1984, Dynamic analysis of structures using Lanczos
/// co-ordinates, Earthquake Eng. Struct. Dyn. 12(4))
class RitzSpace {
  public:
    /// x = K^-1 f, and K x, with what is constrained at zero.
    /// @param f, x, k_x  shape (3 n)
    using SolveStatics = std::function<void(std::span<const double> f, std::span<double> x, std::span<double> k_x)>;

    /// An empty space of a stiffness that is there in its solutions only, as that of mixed elements is: their pressures
    /// are part of it.
    /// @param mass  kept alive by the caller
    RitzSpace(const SymmetricMatrix &mass, SolveStatics solve, std::vector<double> force);

    /// An empty space.
    /// @param stiffness  shape (3 n, 3 n) [N/m]
    /// @param mass       shape (n, n) [kg], of one component
    /// @param solver     of this stiffness, after a factorise() that returned true; the caller keeps it, the stiffness
    ///   and the mass alive
    /// @param force      r, shape (3 n) [N]; what acts on constrained unknowns does not count
    RitzSpace(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass, ConstrainedSolver &solver,
              std::vector<double> force);

    /// Adds a vector.
    /// @return false if there is no other: the motion lies in the space as it is
    bool extend();

    Eigen::Index size() const { return stiffness_of_space_.rows(); }
    /// V, shape (3 n, m) [kg^-1/2], zero where constrained: V^T M V = 1
    auto vectors() const { return vectors_.leftCols(size()); }
    /// V^T K V, shape (m, m) [s^-2]
    const Eigen::MatrixXd &stiffness() const { return stiffness_of_space_; }
    /// V^T r, shape (m) [N kg^-1/2]
    const Eigen::VectorXd &force() const { return force_on_space_; }

  private:
    void solve();
    bool make_orthogonal();

    const SymmetricBlocks<double> *stiffness_ = nullptr;
    const SymmetricMatrix &mass_;
    ConstrainedSolver *solver_ = nullptr;
    SolveStatics solve_statics_;
    std::vector<double> force_;
    std::vector<double> next_load_; ///< what K is solved for next
    std::vector<double> vector_, product_, force_of_vector_;
    Eigen::MatrixXd vectors_; ///< with columns to spare
    Eigen::MatrixXd forces_;  ///< K V where there is no stiffness to multiply by, with as many columns
    Eigen::MatrixXd stiffness_of_space_;
    Eigen::VectorXd force_on_space_;
};

/// The motion M z'' + D z' + K z = r by Newmark's average acceleration, as in Newmark, in a space of m vectors, from
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

/// Lets the tractions of a load case go at t = 0 and follows the body with Newmark's average acceleration and
/// consistent mass, a step per output interval: in the space of its load-dependent Ritz vectors as long as
/// extend_until_converged() finds one, and else as release_step_by_step() does. History::observed_error is what the
/// steps cost the motion of the probes: in the space they are taken again, eight times as short, and else there is
/// error_of_longer_steps().
/// @param body          that the system was assembled from
/// @param load_case     of that body's mesh, with its release
/// @param displacement  where it starts from rest, shape (3 n) [m]
/// @param solver        of the system's stiffness; the factor that it has serves if it holds what the motion holds
/// @throws std::runtime_error if the memory does not hold the factor
core::History release(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                      std::vector<double> displacement, ConstrainedSolver &solver);

/// The same of a stiffness that is there in its solutions only, as that of mixed elements is, with a step per output
/// interval in the space of Ritz vectors.
/// @param force   K u_0 where it starts, reactions included, shape (3 n) [N]
/// @param solve   statics of what the motion holds at zero
/// @return nothing if the space would have to have too many vectors, see extend_until_converged()
std::optional<core::History> release_by_statics(const core::Body &body, const ElasticSystem &system,
                                                const core::LoadCase &load_case,
                                                const std::vector<double> &displacement,
                                                const std::vector<double> &force, RitzSpace::SolveStatics solve);

/// Error of the steps of a motion, by the same motion in steps twice and four times as long: their differences at the
/// records that all three have shrink by a factor r, and what is left after the last difference d is d r / (1 - r). No
/// order better than the second is believed. Where r is beyond core::largest_believed_factor, as with modes that no
/// step resolves, it is taken as that.
/// @param load_case  with the release of the motion, whose steps are its output intervals
/// @param release    the motion of a load case in other steps
/// @return nothing of a motion of fewer than four steps, without probes that move, or that leaves all bounds in one of
///   the three
std::optional<core::ObservedMotionError>
error_of_longer_steps(const core::LoadCase &load_case, const core::History &motion,
                      const std::function<core::History(const core::LoadCase &)> &release);

/// The same motion in steps of the whole body, with a solve each: slow, obvious, and as good with any damping.
core::History release_step_by_step(const core::Body &body, const ElasticSystem &system, const core::LoadCase &load_case,
                                   std::vector<double> displacement);

} // namespace livermark::fem_reference
