#pragma once

#include "results/records/result.hpp"

namespace livermark::results {

/// The reader refuses all of this too, but a file that nobody can read should not come to be.
/// @throws std::invalid_argument if the shapes or names of a result are not as its structs say
void check_shapes(const Result &result);

} // namespace livermark::results
