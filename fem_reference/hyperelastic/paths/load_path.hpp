#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/solution.hpp"
#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/surface/touching_ball.hpp"

namespace livermark::hyperelastic {

/// How loads grow: prescribed displacements, dead loads and follower pressures are all multiplied by one factor, from 0
/// to 1, and the state is kept at each of some fractions.
struct LoadPath {
    std::vector<double> fractions{0.2, 0.4, 0.6, 0.8, 1.0}; ///< ascending, > 0
    /// What is left out of balance, over the reactions and loads, where Newton's method stops.
    double tolerance = 1e-9;
    int max_iterations = 12;            ///< in a load step
    int max_touching_iterations = 24;   ///< the same with a ball: what begins to touch, stick or slip takes some more
    double smallest_step = 1.0 / 256.0; ///< before it gives up, in parts of the way between two fractions
};

/// One load step.
struct LoadStep {
    double fraction = 0.0;         ///< of the load, where it was to end
    bool converged = false;        ///< otherwise a shorter one follows
    std::vector<double> residuals; ///< out of balance over reactions and loads, after the predictor and each iteration
    std::vector<int> linear_iterations; ///< of each linear solve, the predictor's first
};

/// Equilibrium at a fraction of the load.
struct PathPoint {
    double fraction = 0.0;
    TouchSums touch{};  ///< of a ball; its force is in the reactions
    double press = 0.0; ///< what the places that press exert together [N]; not in the reactions
    State state;
    std::vector<core::Vector3> reaction; ///< (P) force of each constraint on the body [N]
    double strain_energy = 0.0;          ///< [J]
    double smallest_jacobian = 0.0;      ///< of all points of integration
};

struct FollowedPath {
    core::SolutionStatus status = core::SolutionStatus::ok;
    std::string message{};            ///< why the status is not ok
    std::vector<PathPoint> points{};  ///< as many fractions as were reached
    std::vector<LoadStep> steps{};    ///< also those that failed
    std::vector<double> linearised{}; ///< (3 n) the linear solution to the whole load [m]
    int factorisations = 0;
    double setup_seconds = 0.0; ///< the first factorisation
    double solve_seconds = 0.0; ///< the rest
};

/// Follows equilibrium as the loads grow, by Newton's method with the consistent tangent. A step begins with a
/// predictor, the tangent's solution for the increments of load and prescribed displacement. Iterations then go as far
/// along their correction as the residual, or its component along it, becomes less and no point of integration turns
/// inside out. A step that does not converge is taken again at half its length. Where places press, it is their depth
/// that grows, and what they exert is one more unknown: each correction is that of the residual plus as much of that of
/// one newton as keeps the depth (displacement control; Batoz, Dhatt 1979, Incremental displacement algorithms for
/// nonlinear problems, Int. J. Numer. Methods Eng. 14).
/// @param conditions         at the whole load; of dof_conditions(), or any of the same sizes
/// @param num_constraints    P, more than any in conditions.constraint
/// @param follower_pressure  shape (T) [Pa], see FollowerPressure; or empty
/// @param ball               what touches the body, or nullptr; its force is the reaction of its constraint. At each
///   fraction its pressures are augmented until it sinks in no more than it may, and its friction is kept for the next:
///   the path is what friction goes by, whatever steps it takes to follow it. No place presses then
/// @return status not_converged, with the points as far as it came, if steps became too short or if the constraints
///   leave the body free to move
/// @throws std::invalid_argument if a constraint in the conditions or of the ball is none of the P
FollowedPath follow(const Elements &elements, const fem_reference::DofConditions &conditions, int num_constraints,
                    std::span<const double> follower_pressure, const LoadPath &path = {}, TouchingBall *ball = nullptr);

class PathSystem;
/// The same of elements that may be spread over ranks; collective then.
FollowedPath follow(PathSystem &system, int num_constraints, const LoadPath &path);

} // namespace livermark::hyperelastic
