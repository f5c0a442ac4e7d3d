#pragma once

#include <vector>

#include "interactive/elements/tetrahedra.hpp"

namespace livermark::interactive {

/// A step of central differences that is stable at rest, 2 / omega with omega the highest angular frequency that any
/// tetrahedron has with its own share of the masses; that of all together is not higher.
/// (Irons, Treharne 1971; Belytschko, Liu, Moran 2000, Nonlinear Finite Elements for Continua and Structures, 6.2.4)
/// @param node_mass  shape (N) [kg]; each tetrahedron's share goes by its volume
/// @return [s]
double critical_time_step(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass);

} // namespace livermark::interactive
