#pragma once

#include <iosfwd>

#include "core/problem.hpp"

namespace livermark::studies {

/// Writes a problem as an unstructured grid of VTK (.vtu, ASCII): tetrahedra with region, young_modulus [Pa],
/// poisson_ratio and density [kg/m^3]; at the nodes is_prescribed (3 flags), prescribed_displacement [m] (zero where
/// free) and nodal_force [N], tractions and weight, consistent with linear tetrahedra.
void write_vtu(std::ostream &out, const core::Problem &problem);

} // namespace livermark::studies
