#pragma once

#include "benchmarks/competitor.hpp"

namespace livermark::benchmarks {

/// Newmark's average acceleration of linear elasticity with a factor that is kept, fem_reference::Newmark, of the
/// scene's body; the springs do not matter.
/// @param degree  of the elements, 1 or 2
Method newmark_method(int degree, int max_refinements);

} // namespace livermark::benchmarks
