#pragma once

#include <string>
#include <vector>

#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "msm/statics/surface_contact.hpp"

namespace livermark::msm {

struct EquilibriumOptions {
    /// Largest accepted norm of the forces out of balance, relative to the norm of the loads and constraint forces.
    /// Where the loads are small beside the stiffness, what the rounding of the positions does to the forces is enough.
    double tolerance = 1e-11;
    int max_iterations = 300;
    /// Memory of what was learnt in equilibria nearby, where the factor is approximate; none for nothing.
    LimitedMemory *memory = nullptr;
    /// Whether a step counts as one downhill where its energy differs by no more than what the rounding of positions
    /// does to it. Loads that strain a body by less than a thousandth need that.
    bool bears_rounding = false;
    const SurfacePressure *pressure = nullptr; ///< beside the loads; its energy alone, see SurfacePressure::rim_force()
    const SurfaceContact *contact = nullptr;   ///< with a ball, as SurfaceContact::update() left it
};

struct Equilibrium {
    core::SolutionStatus status = core::SolutionStatus::ok;
    std::string message;              ///< why the status is not ok
    Field displacement;               ///< (N) [m]
    Field linear_displacement;        ///< (N) solution linearised at rest [m]; empty if a start was given
    Field constraint_force;           ///< (N) [N], of the constraints on the nodes; zero on free ones
    double press = 0.0;               ///< what the places that press exert together [N]
    std::vector<core::Vector3> touch; ///< what each of LoadCase::contacts() exerts [N]; or empty
    int num_iterations = 0;           ///< steps downhill
    int num_factors = 0;              ///< factorisations beside that of the body at rest
};

/// The solution linearised at rest; where places press, of the force that moves the body by their depth.
/// @param memory  see RestStiffness::solve()
/// @return shape (N) [m]
Field linear_solution(const RestStiffness &rest, const NodalConditions &conditions, LimitedMemory *memory = nullptr);

/// Place where an elastic body comes to rest under dead loads: a minimum of U(x) - f . u over the free components, from
/// the solution linearised at rest downhill. The steps are those of Newton's method with one sparse Cholesky factor for
/// many of them, which the steps themselves correct (limited-memory BFGS), and a backtracking line search. The first
/// factor is that of the body at rest; where it does not lead on quickly, one of the second derivative where the body
/// is now follows. The body is geometrically non-linear. Where the exact second derivative is not positive definite, a
/// part of what compression makes negative is left out of the step (not out of the solution). Of a body that gives way
/// under its load (buckles) this finds where it comes to rest after that. Where places press, it is the minimum of U
/// among the displacements u with f . u the depth, and what they exert is the multiplier of that condition: steps are
/// projected onto those that keep it (Gould, Hribar, Nocedal 2001, On the solution of equality constrained quadratic
/// programming problems, SIAM J. Sci. Comput. 23, section 3).
/// @param body        at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  loads and prescribed displacements of the nodes
/// @return status not_converged, with what went wrong, where no equilibrium was found
Equilibrium find_equilibrium(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                             const EquilibriumOptions &options = {});

/// The same with a stiffness at rest that is there already.
/// @param rest   of the body and positions; constrains the components that the conditions prescribe
/// @param start  shape (N) displacement from which it goes downhill [m], with what is prescribed and at the depth; if
///   empty, the solution linearised at rest
Equilibrium find_equilibrium(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                             const RestStiffness &rest, const EquilibriumOptions &options = {}, Field start = {});

} // namespace livermark::msm
