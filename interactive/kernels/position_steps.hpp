#pragma once

#include "interactive/kernels/position_rows.hpp"

namespace livermark::interactive::kernels {

/// A step as PositionBased takes it, in single precision on the vectors of the machine: each iteration visits the sets
/// in their order and the batches of each in theirs. Constrained nodes keep their velocities.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
void take_position_step(PositionRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
