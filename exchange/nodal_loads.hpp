#pragma once

#include <vector>

#include "core/problem.hpp"

namespace livermark::exchange {

/// What is prescribed at each node, NaN where a component is free. Where constraints meet, the one of lowest index
/// wins, as it does for every model.
/// @return shape (N) [m]
std::vector<core::Vector3> prescribed_displacement(const core::Problem &problem);

/// Tractions and the acceleration as forces on nodes, consistent with linear tetrahedra: a facet's force goes in thirds
/// to its corners, a tetrahedron's weight in quarters.
/// @return shape (N) [N]
std::vector<core::Vector3> nodal_forces(const core::Problem &problem);

} // namespace livermark::exchange
