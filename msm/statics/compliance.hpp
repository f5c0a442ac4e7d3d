#pragma once

#include <span>

#include "core/mesh/interior_place.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// How a body of point masses gives way inside, linearised at rest: nodes take forces on places, and places the means
/// of displacements, with the weights of linear tetrahedra.
/// @param body  at rest on the mesh of the problem
/// @return without seconds
/// @throws support::InputError if the load case leaves the body free to move, or the springs do not hold it up
/// @throws std::invalid_argument if a place is outside the body
core::Compliance compliance(const ElasticBody &body, const core::Problem &problem,
                            std::span<const core::InteriorPlace> places);

} // namespace livermark::msm
