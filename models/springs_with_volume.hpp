#pragma once

#include <string_view>

#include "models/mass_spring_model.hpp"
#include "msm/spring_law.hpp"
#include "msm/volume_term.hpp"

/// Springs that carry lambda = mu of the material beside a volume term that carries the rest, so that any Poisson's
/// ratio can be had.
namespace livermark::models {

/// The springs of a law for a material with the body's shear modulus and lambda = mu: Young's modulus 5 mu / 2 and
/// Poisson's ratio 1/4.
core::SpringNetwork springs_beside_volume(const core::Body &body, const msm::SpringLaw &law);

/// What resists changes of volume with what is left of lambda.
std::shared_ptr<const msm::ElasticTerm> volume_beside_springs(const core::Body &body, const msm::VolumeTerm &term);

/// Both together, at Poisson's ratio 1/4 the springs alone. Tetrahedra are kept from turning inside out.
MassSprings springs_with_volume(const core::Body &body, core::SpringNetwork springs, const msm::VolumeTerm &term);

/// @throws std::logic_error if there is no volume term of that name
const msm::VolumeTerm &find_volume_term(std::string_view name);

} // namespace livermark::models
