#pragma once

#include <vector>

#include "core/load_case.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/dynamics/motion.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// Point masses with an elastic energy under dead loads, with unknown 3 i + component for node i:
/// M u'' = f - grad U(x + u) - alpha M v - beta K_m(x + u) v,
/// K_m the material tangent: on springs the last term is axial dashpots of beta k. It is beta K v at rest (Rayleigh
/// damping) and leaves rigid motion alone. Prescribed components stay where the motion starts.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param scaling     of masses in the accelerations; effective_mass, for implicit integrators, has none of it
/// @return of 3N unknowns
EquationOfMotion elastic_motion(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                const NodalConditions &conditions, const core::RayleighDamping &damping,
                                const MassScaling &scaling = {});

/// 1/2 v^T M v [J]
double kinetic_energy(const EquationOfMotion &equation, const State &state);

} // namespace livermark::msm
