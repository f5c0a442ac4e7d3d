#pragma once

#include <span>
#include <string>
#include <vector>

#include "msm/integrator.hpp"

/// Integrators that solve systems of equations in each step. They stand apart because their factors are CHOLMOD's,
/// which the explicit ones do without.
namespace livermark::msm {

/// Every integrator of implicit_integrators/, in alphabetical order.
std::span<const Integrator> all_implicit_integrators();

/// The explicit and the implicit ones together, in alphabetical order.
const std::vector<Integrator> &known_integrators();

/// @throws support::InputError if there is none of that name among known_integrators()
const Integrator &find_known_integrator(const std::string &name);

} // namespace livermark::msm
