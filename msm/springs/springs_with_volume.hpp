#pragma once

#include <string_view>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_curve.hpp"
#include "msm/spring_law.hpp"
#include "msm/volume_term.hpp"

/// Springs that carry lambda = mu of the material beside a volume term that carries the rest, so that any Poisson's
/// ratio can be had.
namespace livermark::msm {

/// What a mass-spring model makes of a body.
struct MassSprings {
    core::SpringNetwork springs; ///< kept in the result file
    ElasticBody body;            ///< what moves: the springs, and what else resists
};

/// The same body for the law of springs beside a volume term: with the body's shear modulus and lambda = mu.
core::Body for_springs_beside_volume(core::Body body);

/// The springs of a law for a material with the body's shear modulus and lambda = mu: Young's modulus 5 mu / 2 and
/// Poisson's ratio 1/4.
core::SpringNetwork springs_beside_volume(const core::Body &body, const SpringLaw &law);

/// What is left of lambda for a volume term [Pa].
double modulus_beside_springs(const core::Material &material);

/// Whether anything is left of lambda: not at Poisson's ratio 1/4.
bool needs_volume(const core::Body &body);

/// What resists changes of volume with what is left of lambda.
std::shared_ptr<const ElasticTerm> volume_beside_springs(const core::Body &body, const VolumeTerm &term);

/// Both together, at Poisson's ratio 1/4 the springs alone. Tetrahedra are kept from turning inside out.
MassSprings springs_with_volume(const core::Body &body, core::SpringNetwork springs, const VolumeTerm &term,
                                const ForceCurve &curve = hooke);

/// @throws support::InputError if there is no volume term of that name
const VolumeTerm &find_volume_term(std::string_view name);

} // namespace livermark::msm
