#pragma once

#include <string>

#include "studies/advise/advise.hpp"

namespace livermark::studies {

/// An advice for programs: an object with body, evidence, touch, position, linear_tetrahedra, over_budget and caveats.
/// SI units, errors as parts of one. What is not known is left out. Names are those of the structs, and
/// docs/reference/advice.md has the list.
std::string to_json(const Advice &advice);

} // namespace livermark::studies
