#pragma once

#include "core/problem.hpp"

namespace livermark::studies {

/// Interactive methods constrain whole nodes.
/// @throws support::InputError if a place of the load case leaves a component of its displacement free
void refuse_single_components(const core::LoadCase &load_case);

} // namespace livermark::studies
