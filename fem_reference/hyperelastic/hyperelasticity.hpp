#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/tool/needle/needle.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/hyperelastic/surface.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"

namespace livermark::hyperelastic {

/// One load step.
struct LoadStep {
    double fraction = 0.0;         ///< of the load, where it was to end
    bool converged = false;        ///< otherwise a shorter one follows
    std::vector<double> residuals; ///< out of balance over reactions and loads, after the predictor and each iteration
    std::vector<int> linear_iterations; ///< of each linear solve, the predictor's first
};

/// Growth of loads: prescribed displacements, dead loads and follower pressures are all multiplied by one factor, from
/// 0 to 1, and the state is kept at each of some fractions.
struct LoadPath {
    std::vector<double> fractions{0.2, 0.4, 0.6, 0.8, 1.0}; ///< ascending, > 0
    /// Remainder out of balance, over the reactions and loads, where Newton's method stops.
    double tolerance = 1e-9;
    int max_iterations = 12;            ///< in a load step
    int max_touching_iterations = 24;   ///< the same with a ball: what begins to touch, stick or slip takes some more
    double smallest_step = 1.0 / 256.0; ///< before it gives up, in parts of the way between two fractions
    /// Observer of a load step, called before and after its predictor and after each iteration; what it throws ends the
    /// search.
    std::function<void(const LoadStep &)> observe{};
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

/// Which elements.
struct Discretisation {
    int degree = 2;                                                                    ///< 1 or 2, of the displacement
    fem_reference::Formulation formulation = fem_reference::Formulation::displacement; ///< mixed for degree 2 only
    /// Values of quadratic elements; on linear ones everything is constant.
    TetrahedronRule rule = TetrahedronRule::fourteen_points;
    bool observes_steps = false; ///< of a motion, for History::observed_error; takes three quarters of its time more
};

/// Equilibrium at the mesh nodes at a fraction of the load.
struct DeformedBody {
    double fraction = 0.0;
    std::vector<core::Vector3> displacement; ///< (N) [m]
    std::vector<core::Vector3> reaction;     ///< (P) force of each constraint on the body [N]
    double strain_energy = 0.0;              ///< [J]
    double smallest_jacobian = 0.0;          ///< least J = det F of all points of integration
};

struct PathSolution {
    /// At the whole load, or where it ended; nonlinearity is set. The message of a path that ended says why.
    core::Solution solution;
    std::vector<DeformedBody> points; ///< at each fraction of the path; if it ended earlier, also there
    std::vector<LoadStep> steps;      ///< how Newton's method went
    /// Sum of f_i . u_i over all nodes of the elements, f being the dead loads at the whole load [J]; NaN if it ended
    /// early.
    double load_work = std::numeric_limits<double>::quiet_NaN();
    std::vector<core::Vector3> at_places{}; ///< (K) displacements of inner forces at the whole load [m]
};

/// Static hyperelasticity of one body on its own tetrahedra, in its shape at rest (total Lagrangian):
/// Div P + rho a = 0 with P = dW / dF, prescribed displacements and dead tractions per area at rest as in the load case
/// (see fem_reference::StaticSolver), pressures that follow the surface, and a ball that touches it (TouchingBall).
/// @param problem            load case at the whole load; of a time-dependent one the history too, see release(), but
///   not in the mixed formulation
/// @param follower_pressure  shape (T) [Pa], positive inwards, on facets of any condition; or empty
/// @param inner              dead loads at places inside, beside the load case
/// @return status not_converged if the path ended early, diverged if the motion did; NaN fields if the load case leaves
/// the body free to move
/// @throws std::invalid_argument for elements that do not exist, a load case or pressures that are not of the mesh, or
///   fractions that do not ascend to 1
/// @throws std::runtime_error if the memory does not hold a factor
PathSolution solve(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                   const LoadPath &path = {}, std::span<const double> follower_pressure = {},
                   const fem_reference::InnerForces &inner = {});

/// solve() in the mixed formulation, by all ranks of MPI_COMM_WORLD together: the same path, the same Newton steps, and
/// linear systems as in fem_reference::DistributedSaddlePoint.
/// Collective: every rank calls it, with the same problem, while an MpiSession lives, and gets the solution on the
/// mesh. If a rank fails where the others cannot know of it (out of memory), it says so and ends them all.
/// @throws std::invalid_argument as solve() does, on every rank
PathSolution solve_distributed(const core::Problem &problem, const MaterialLaw &law, const LoadPath &path = {},
                               std::span<const double> follower_pressure = {});

/// @throws std::invalid_argument if the fractions do not ascend to 1
void check(const LoadPath &path);

/// Parts of a path on the mesh, all but degrees of freedom and solver.
/// @param at_mesh_nodes  (N) of displacements of the elements
PathSolution path_solution(const FollowedPath &followed, const core::TetraMesh &mesh, const core::LoadCase &load_case,
                           const std::function<std::vector<core::Vector3>(const std::vector<double> &)> &at_mesh_nodes);

/// A path that cannot begin, because the load case leaves the body free to move.
FollowedPath free_to_move();

/// For the result file.
/// @param inverses  "factors by CHOLMOD" or the like
std::string description(const FollowedPath &path, const std::string &inverses);

/// A hyperelastic body that is pushed at places inside, see solve(). Each push is an equilibrium by Newton's method
/// from the last one; where that fails, forces go there in up to 32 parts.
/// @param problem     what its load case constrains stays where it is at rest, and its loads do not act
/// @param compliance  shape (3 K, 3 K) [m/N], of this body at rest or of one that is about as stiff
/// @throws support::InputError if the load case leaves the body free to move
/// @throws std::invalid_argument if a place is outside the body
std::unique_ptr<core::PushedBody> pushed_elements(const core::Problem &problem, const MaterialLaw &law,
                                                  const Discretisation &discretisation,
                                                  std::span<const core::InteriorPlace> places,
                                                  Eigen::MatrixXd compliance);

/// Hyperelasticity whose isochoric stress relaxes by one Prony series in all regions, quasi-static, along a slow
/// history: at each point of integration the branches follow isochoric_stress() by the exponential update of
/// core::BranchStep, and each step has a potential (IsochoricPart), whose equilibrium Newton's method finds as on a
/// path of loads. Steps are those of the history, and their halves where it finds none. The error is of second order
/// in the steps.
/// @param problem            with a slow history; a release is not looked at
/// @param tolerance          as LoadPath::tolerance
/// @param follower_pressure  as of solve()
/// @return a core::PathPoint for each time; the other fields are those of SlowHistory::whole_load_record().
///   strain_energy is that of the elastic law after all time, and of the branches as if their strains were small,
///   and dissipated_energy what these branches lose. Status not_converged if the way ended early.
/// @throws as solve()
core::Solution solve_history(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                             double tolerance, std::span<const double> follower_pressure = {});

} // namespace livermark::hyperelastic
