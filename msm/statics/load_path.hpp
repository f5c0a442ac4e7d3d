#pragma once

#include "core/problem.hpp"
#include "core/tool/touched_facets.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::msm {

/// Where a body is on the way to the whole load, and there.
struct FollowedPath {
    Equilibrium end; ///< at the whole load, or where it ended; iterations and factors are those of the whole way
    std::vector<core::PathPoint>
        points;        ///< at the parts of LoadCase::path, as far as it came; reactions and displacements
    int num_steps = 0; ///< equilibria
};

/// Follows equilibrium along LoadCase::path as all that drives the body grows. A step begins where the last one ended,
/// and goes on by the solution linearised at rest to what was added; one without an equilibrium is taken again in
/// halves. See EquilibriumSearch on pressures that follow the surface. Under a ball that touches equilibria follow one
/// another as SurfaceContact says, and its friction is that of these steps.
/// @param problem            with a path
/// @param node_mass          shape (N) [kg]
/// @param rest               as for find_equilibrium()
/// @param contact_stiffness  gamma of core::touched_facets()
/// @return status not_converged with the points as far as it came
FollowedPath follow_path(const ElasticBody &body, const core::Problem &problem, const std::vector<double> &node_mass,
                         const RestStiffness &rest, double contact_stiffness = core::usual_contact_stiffness);

} // namespace livermark::msm
