#pragma once

#include <memory>

#include "interactive/method.hpp"
#include "msm/dynamics/time_step.hpp"

/// Selective mass scaling of explicit methods, by the same rules as of springs (msm/dynamics/time_step.hpp).
namespace livermark::models {

/// Scales the stiff parts of a body so that they bear the steps of the rest.
/// @param at_rest  whose constrained nodes belong to no part; nodes of the method's own belong to a part where the
///   edges are that they are on
msm::MassScaling scale_masses(const interactive::Simulation &at_rest);

/// The same where more nodes are constrained: those of a scene.
msm::MassScaling constrained(const msm::MassScaling &scaling, const interactive::Scene &scene);

/// The longest stable step with these masses.
/// @param scaling  with no part that has a constrained node
/// @return [s]; infinity if nothing can move
double critical_time_step(const interactive::Simulation &at_rest, const msm::MassScaling &scaling);

/// Correction that makes explicit steps those of the scaled masses. Damping by mass is in proportion to these.
/// @return null where no part is scaled
std::shared_ptr<interactive::StepCorrection> correction_of(msm::MassScaling scaling);

} // namespace livermark::models
