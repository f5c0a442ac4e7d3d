#pragma once

#include <string>
#include <vector>

#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"

namespace livermark::studies {

/// @throws support::InputError if there is none of that name, with the nearest one that there is
msm::SpringLaw find_spring_law(const std::string &name);

/// The integrators that were named, in that order; all if none was.
/// @throws support::InputError for a name that there is not, or that comes twice
std::vector<msm::Integrator> find_integrators(const std::vector<std::string> &names);

} // namespace livermark::studies
