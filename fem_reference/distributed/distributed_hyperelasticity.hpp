#pragma once

#include "fem_reference/hyperelastic/hyperelasticity.hpp"

namespace livermark::hyperelastic {

/// solve() in the mixed formulation, by all ranks of MPI_COMM_WORLD together: the same path, the same Newton steps, and
/// linear systems as in fem_reference::DistributedSaddlePoint.
/// Collective: every rank calls it, with the same problem, while an MpiSession lives, and gets the solution on the
/// mesh. If a rank fails where the others cannot know of it (out of memory), it says so and ends them all.
/// @throws std::invalid_argument as solve() does, on every rank
PathSolution solve_distributed(const core::Problem &problem, const MaterialLaw &law, const LoadPath &path = {},
                               std::span<const double> follower_pressure = {});

} // namespace livermark::hyperelastic
