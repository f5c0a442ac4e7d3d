#pragma once

#include <vector>

#include "benchmarks/competitor.hpp"

namespace livermark::benchmarks {

/// The kernels of msm/, each on springs alone and on springs with the volume around nodes and the inversion guard, on
/// one thread and, the fast ones, on as many as the machine runs at a time.
std::vector<Competitor> our_kernels();

} // namespace livermark::benchmarks
