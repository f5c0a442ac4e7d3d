#pragma once

#include "interactive/kernels/corotational/corotational_rows.hpp"

namespace livermark::interactive::kernels {

/// A linearised step of backward Euler as CorotationalImplicit takes it, in single precision on the vectors of the
/// machine: rotations, and conjugate gradients from the velocities with the blocks of nodes as preconditioner.
/// Constrained nodes keep their velocities. Points that are touched take part as springs.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
/// @param iterations    of conjugate gradients, fewer where nothing is left to do
void take_corotational_step(CorotationalRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
