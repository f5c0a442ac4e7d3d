#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/hyperelastic/paths/load_path.hpp"
#include "fem_reference/linear/formulation.hpp"

namespace livermark::hyperelastic {

/// Which elements.
struct Discretisation {
    int degree = 2;                                                                    ///< 1 or 2, of the displacement
    fem_reference::Formulation formulation = fem_reference::Formulation::displacement; ///< mixed for degree 2 only
    /// Of quadratic elements; on linear ones everything is constant.
    TetrahedronRule rule = TetrahedronRule::fourteen_points;
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
};

/// Static hyperelasticity of one body on its own tetrahedra, in its shape at rest (total Lagrangian):
/// Div P + rho a = 0 with P = dW / dF, prescribed displacements and dead tractions per area at rest as in the load case
/// (see fem_reference::StaticSolver), pressures that follow the surface, and a ball that touches it (TouchingBall).
/// @param problem            load case at the whole load; of a time-dependent one the history too, see release(), but
///   not in the mixed formulation
/// @param follower_pressure  shape (T) [Pa], positive inwards, on facets of any condition; or empty
/// @return status not_converged if the path ended early, diverged if the motion did; NaN fields if the load case leaves
/// the body free to move
/// @throws std::invalid_argument for elements that do not exist, a load case or pressures that are not of the mesh, or
///   fractions that do not ascend to 1
/// @throws std::runtime_error if the memory does not hold a factor
PathSolution solve(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                   const LoadPath &path = {}, std::span<const double> follower_pressure = {});

} // namespace livermark::hyperelastic
