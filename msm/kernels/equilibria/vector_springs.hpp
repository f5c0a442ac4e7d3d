#pragma once

#include <vector>

#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// The same body for those who look for its equilibria, with one term that finds energies, forces and products with
/// second derivatives in vectors of double precision where the fast kernels know how: for springs that are coupled
/// around nodes, see coupled_arrays(). Numbers differ from those of the terms by rounding. All else is still asked of
/// these.
/// @param positions  shape (N) of rest [m]
/// @return a copy of the body where the kernels do not know how
ElasticBody in_vectors(const ElasticBody &body, const std::vector<core::Vector3> &positions);

} // namespace livermark::msm
