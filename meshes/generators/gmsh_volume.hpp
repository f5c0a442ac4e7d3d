#pragma once

#include "meshes/generators/surface_mesh.hpp"

namespace livermark::meshes {

/// Fills a closed surface with tetrahedra, and each surface inside it with a region of its own (gmsh Delaunay with one
/// thread and gmsh's own optimisation). The surfaces are kept as they are.
/// @param outer         the boundary
/// @param inclusions    surfaces inside it, apart from it and from each other
/// @param largest_size  gmsh's size away from fine surfaces [m]; the inner edges come out about 1.2 times as long
/// @return points: those of outer, then of the inclusions, then the inner ones; region 0 is outside the inclusions and
///         region i in the i-th; tetrahedra region by region, positive volume; no names, no boundary
/// @throws std::runtime_error  if gmsh fails
core::TetraMesh fill_with_tetrahedra(const SurfaceMesh &outer, const std::vector<SurfaceMesh> &inclusions,
                                     double largest_size);

} // namespace livermark::meshes
