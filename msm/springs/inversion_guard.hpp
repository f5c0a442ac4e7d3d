#pragma once

#include <memory>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// What keeps tetrahedra from turning inside out, and turns them back: springs are content with a mirror image, and a
/// volume around a node may be kept while one of its tetrahedra is inverted.
///   U = sum over tetrahedra t of m_t / 2 (max(0, c V0_t - V_t))^2 / V0_t,   m_t = 4 (lambda + 2 mu),   c = 1/2
/// It is zero, with all its derivatives, as long as each tetrahedron keeps half its volume, so it changes no solution
/// to a small load and no critical time step; steps that are to bear it have to be shorter.
std::shared_ptr<const ElasticTerm> inversion_guard(const core::Body &body);

/// The guard as if every tetrahedron were below half its volume, at rest: with it the highest frequency is that of a
/// body pressed so far, which bounds the time step of one that is handled roughly.
std::shared_ptr<const ElasticTerm> pressed_guard(const core::Body &body);

} // namespace livermark::msm
