#pragma once

#include <vector>

#include "core/solution.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"

/// Free vibrations of a body linearised at rest, K phi = omega^2 M phi with K the material tangent and M the node
/// masses. What is prescribed is constrained at zero, whatever its value; loads do not count.
namespace livermark::msm {

/// The lowest modes by shift-invert about zero: Lanczos's method with implicit restarts (Spectra) for the largest
/// eigenvalues 1 / omega^2 of the inverse of M^-1/2 K M^-1/2, with one sparse Cholesky factor of it.
/// @param body        masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @param count       at least 1
/// @param scaling     of the masses
/// @return shapes of M-norm 1 with their largest entry positive
/// @throws support::InputError if what is constrained leaves the body free to move, or if it has fewer modes than that
/// @throws std::runtime_error if the iteration does not converge
core::Modes lowest_modes(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                         const NodalConditions &conditions, int count, const MassScaling &scaling = {});

} // namespace livermark::msm
