#pragma once

#include "interactive/kernels/explicit_rows.hpp"

namespace livermark::interactive::kernels {

/// Steps of central differences as ExplicitTetrahedra takes them, in single precision on the vectors of the machine: a
/// pass over tetrahedra and one over nodes, and before these one for J of tetrahedra and one for pressures of nodes
/// where they are around nodes. Quadratic tetrahedra are neo-Hookean at their four points. Constrained nodes keep their
/// velocities. A tetrahedron that is inside out makes NaN, as the logarithm of its J does.
/// @param step          h of one [s]
/// @param mass_damping  alpha [1/s]
void take_explicit_steps(ExplicitRows &rows, double step, double mass_damping, int num_steps);

} // namespace livermark::interactive::kernels
