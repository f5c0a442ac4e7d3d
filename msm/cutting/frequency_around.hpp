#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// The highest frequency of what is around a wound, with all else constrained: of the tetrahedra that are left within
/// some rings of tetrahedra around its nodes, set up as a small body of their own. What is constrained more has no
/// higher frequency (Cauchy's interlacing), so that of the whole body is no lower. A mode at the wound does not reach
/// far, and elsewhere nothing has changed: the larger of this and of the frequency before the cut is that of the whole
/// cut body, where the mode before is not at the wound itself.
/// @param body        before the cut, at rest
/// @param is_removed  shape (M) what is gone
/// @param nodes       that have lost tetrahedra
/// @param make        the springs of a body
/// @param conditions  of the nodes of the body
/// @param tolerance   of Lanczos's method, relative
/// @return [rad/s]; zero if nothing there can move
double frequency_around(const core::Body &body, const std::vector<char> &is_removed, std::span<const int> nodes,
                        const std::function<ElasticBody(const core::Body &)> &make, const NodalConditions &conditions,
                        double tolerance);

} // namespace livermark::msm
