#pragma once

#include <memory>
#include <span>

#include "core/mesh/interior_place.hpp"
#include "core/problem.hpp"
#include "core/tool/needle/pushed_body.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// A body of point masses that is pushed at places inside: nodes take forces on places, and places the means of
/// displacements, with the weights of linear tetrahedra. Each push is find_equilibrium() from the last one; where that
/// fails, forces go there in up to 32 parts. The compliance is that at rest.
/// @param body     at rest on the mesh of the problem
/// @param problem  what its load case constrains stays where it is at rest, and its loads do not act
/// @throws as compliance()
std::unique_ptr<core::PushedBody> pushed_springs(ElasticBody body, const core::Problem &problem,
                                                 std::span<const core::InteriorPlace> places);

} // namespace livermark::msm
