#pragma once

#include <functional>
#include <vector>

#include "core/problem.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// Scales the masses of what a cut leaves: scale_masses() of the body without the tetrahedra that are gone, set up as a
/// body of its own, in the numbers that nodes have before the cut. A stiff part that a cut goes through is one part or
/// several then. It looks for frequencies, and so takes longer than a step; FastSteps::set_scaling() takes what it
/// finds while the body moves.
/// @param body        before the cut, at rest
/// @param is_removed  shape (M) what is gone
/// @param make        the springs of a body
/// @param conditions  of the nodes of the body
MassScaling scale_masses_of_rest(const core::Body &body, const std::vector<char> &is_removed,
                                 const std::function<ElasticBody(const core::Body &)> &make,
                                 const NodalConditions &conditions);

} // namespace livermark::msm
