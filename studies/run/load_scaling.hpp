#pragma once

#include "studies/run/prepared_models.hpp"

namespace livermark::studies {

/// Multiplies what drives a problem until the linear baseline reaches the target of its load case, where that asks for
/// it (LoadCase::scale_to_target), within 5e-6; the factor, of six digits, goes into LoadCase::load_scale.
/// @param baseline  linear; if it is collective all MPI ranks have to call this
/// @param prepared  what the baseline solves with
/// @return with scale_to_target off, so that nobody scales twice
/// @throws std::runtime_error if the baseline finds no solution, or one that does not move
core::Problem scaled_to_target(core::Problem problem, const core::Model &baseline, PreparedModels &prepared);

/// The same by the baseline of the model table, for commands of one rank.
/// @throws support::InputError on several MPI ranks, where the baseline would wait for the others
core::Problem scaled_to_target(core::Problem problem);

} // namespace livermark::studies
