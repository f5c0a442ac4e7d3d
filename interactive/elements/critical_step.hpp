#pragma once

#include <vector>

#include "interactive/elements/tetrahedra.hpp"
#include "interactive/energy.hpp"

namespace livermark::interactive {

/// The longest stable step of central differences at rest, 2 / omega with omega the highest angular frequency of
/// K phi = omega^2 M phi, K the second derivative of the energy, where what is constrained stays: Lanczos's method on
/// differences of forces, without a matrix, to a ten thousandth of omega^2. The same scene gives the same bits.
/// @return [s]; infinity if nothing can move
/// @throws std::runtime_error if the iteration does not converge
double critical_time_step(const Energy &energy, const Scene &scene);

/// A bound on it from below, without an iteration: 2 / omega with omega the highest angular frequency that any
/// tetrahedron has with its own share of the masses. (Irons, Treharne 1971; Belytschko, Liu, Moran 2000, Nonlinear
/// Finite Elements for Continua and Structures, 6.2.4)
/// @param node_mass  shape (N) [kg]; each tetrahedron's share goes by its volume
/// @return [s]
double critical_time_step_bound(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass);

} // namespace livermark::interactive
