#pragma once

#include "interactive/kernels/descent/descent_rows.hpp"

namespace livermark::interactive::kernels {

/// A step of vertex block descent in single precision on the vectors of the machine: displacements go on to where the
/// velocity and the external acceleration that the last step followed lead, and each iteration visits the batches in
/// their order, with the weights of chebyshev.hpp. The rows of constrained nodes in predicted are their targets.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
void take_descent_step(DescentRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
