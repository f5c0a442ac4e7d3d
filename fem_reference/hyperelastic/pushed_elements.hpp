#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "core/mesh/interior_place.hpp"
#include "core/problem.hpp"
#include "core/tool/needle/pushed_body.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"

namespace livermark::hyperelastic {

/// A hyperelastic body that is pushed at places inside, see solve(). Each push is an equilibrium by Newton's method
/// from the last one; where that fails, forces go there in up to 32 parts.
/// @param problem     what its load case constrains stays where it is at rest, and its loads do not act
/// @param compliance  shape (3 K, 3 K) [m/N], of this body at rest or of one that is about as stiff
/// @throws support::InputError if the load case leaves the body free to move
/// @throws std::invalid_argument if a place is outside the body
std::unique_ptr<core::PushedBody> pushed_elements(const core::Problem &problem, const MaterialLaw &law,
                                                  const Discretisation &discretisation,
                                                  std::span<const core::InteriorPlace> places,
                                                  Eigen::MatrixXd compliance);

} // namespace livermark::hyperelastic
