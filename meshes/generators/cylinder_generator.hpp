#pragma once

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Side of a cube of the same volume as a cylinder, whose height counts as an edge at least [m]: see
/// expected_tetrahedra().
double side_of_cube_like_cylinder(double radius, double height, double edge_length);

/// A cylinder around the z axis from z = 0 to the height, in tetrahedra: one region "solid", and the patches "side",
/// "z_min" and "z_max". Unstructured: gmsh, one thread. The same arguments give the same mesh. The side is of flat
/// triangles with corners on the cylinder, so that the volume is a little smaller than that of the cylinder.
/// @param radius, height  [m], > 0
/// @param edge_length     wanted edge length [m], > 0 and at most the radius
/// @throws support::InputError   if a length is not positive and finite, or the edges are longer than the radius
/// @throws std::runtime_error if gmsh fails
core::TetraMesh generate_cylinder(double radius, double height, double edge_length);

} // namespace livermark::meshes
