#pragma once

#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::fem_reference {

/// Lowest modes of a body constrained where the load case prescribes displacements (at zero, whatever the value; its
/// loads do not count), with linear or quadratic elements and consistent mass. See lowest_eigenpairs for the method.
/// @param degree  1 or 2
/// @param count   at least 1
/// @throws support::InputError if the load case leaves the body free to move, or if it has fewer modes than that
/// @throws std::invalid_argument for another degree, or a load case of another mesh
core::Modes lowest_modes(const core::Problem &problem, int degree, int count);

} // namespace livermark::fem_reference
