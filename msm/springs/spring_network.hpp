#pragma once

#include <memory>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_curve.hpp"
#include "msm/spring_law.hpp"

namespace livermark::msm {

/// The springs of a body: an edge of the mesh each, at rest in the mesh.
core::SpringNetwork spring_network(const core::Body &body, const SpringLaw &law);

/// The energy of springs, U = sum over springs of k (l - l0)^2 / 2. Where it is asked for forces, no two ends of a
/// spring may be in one place. Second derivative: k [n n^T + (1 - l0/l) (I - n n^T)] with n along the spring; the first
/// part is the material one, and the second is negative where the spring is compressed.
std::shared_ptr<const ElasticTerm> spring_term(const core::SpringNetwork &springs);

/// The same with another curve, U = sum over springs of k l0^2 energy(l / l0). Second derivative: k [slope n n^T +
/// force l0/l (I - n n^T)].
std::shared_ptr<const ElasticTerm> spring_term(const core::SpringNetwork &springs, const ForceCurve &curve);

} // namespace livermark::msm
