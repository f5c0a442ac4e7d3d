#pragma once

#include <vector>

#include "interactive/minimiser.hpp"
#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// A static solution.
struct Equilibrium {
    Field positions;      ///< shape (3, N) [m], as far as the load went
    Field elastic_forces; ///< shape (3, N) [N]; minus these and the external forces is what constrained nodes need
    bool converged = false;
    double fraction = 0.0; ///< of the load that was reached, that which was wanted if converged
    int iterations = 0;    ///< of Newton's method, from the start of the path
    double load = 0.0;     ///< what the external forces were multiplied by: the fraction, or newtons where they press
};

/// What a method comes to when nothing moves and nothing limits its iterations: the least of its energy less the work
/// of the external forces, with the constrained nodes at their targets. Newton's method, along a path on which forces
/// and displacements of constrained nodes grow together; a load step that does not converge is taken again at half its
/// length.
/// @param simulation  with the forces and targets of the whole load; it stays as it is
/// @param fractions   of the load, ascending, > 0
/// @param press_depth  if not 0, the external forces are those of one newton, and are multiplied by what it takes until
///   the sum of their products with the displacements is this depth [m]; targets are where nodes are at rest then
/// @return one for each fraction; the last is not converged, and there are none behind it, where the path ended early
std::vector<Equilibrium> equilibria(const Simulation &simulation, const std::vector<double> &fractions,
                                    double tolerance = 1e-9, double press_depth = 0.0);

} // namespace livermark::interactive
