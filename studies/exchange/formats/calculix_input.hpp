#pragma once

#include <iosfwd>

#include "core/problem.hpp"

namespace livermark::studies {

/// Writes a static problem as CalculiX (and Abaqus) input: C3D4 or C3D10 with straight edges, a *MATERIAL and an ELSET
/// for each region, *BOUNDARY for what is prescribed, *CLOAD with the consistent nodal forces of the tractions (a
/// facet's force goes in equal parts to its corners, or to its edge midpoints), *DLOAD GRAV for the acceleration. Node
/// i of the mesh is node i + 1, tetrahedron t is element t + 1, the middle of edge e of core::edge_table is node N + e
/// + 1; lengths are metres, forces newtons. Every displacement goes to the .dat file.
///
/// A load case of the large regime is geometrically nonlinear (NLGEOM) and *HYPERELASTIC, NEO HOOKE with the same Lame
/// parameters, an energy that is not quite that of the suite,
///     W = mu / 2 (J^(-2/3) I1 - 3) + kappa / 2 (J - 1)^2,   kappa = lambda + 2 mu / 3.
/// Pressures that follow the surface are *DLOAD on faces.
/// @param degree  1 or 2
void write_inp(std::ostream &out, const core::Problem &problem, int degree);

} // namespace livermark::studies
