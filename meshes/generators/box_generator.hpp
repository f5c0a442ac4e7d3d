#pragma once

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

enum class BoxTopology {
    delaunay,     ///< unstructured: gmsh, one thread
    body_centred, ///< Lattice::body_centred
    kuhn          ///< Lattice::kuhn
};

/// Side of a cube of the same volume as a box, whose sides count as an edge at least [m]: see expected_tetrahedra().
double side_of_cube_like_box(const core::Vector3 &size, double edge_length);

/// A box [0, a] x [0, b] x [0, c] in tetrahedra: one region "solid", a patch for each side, "x_min", "x_max", "y_min",
/// "y_max", "z_min", "z_max". The same arguments give the same mesh.
/// @param size         a, b, c [m], > 0
/// @param edge_length  wanted edge length [m], > 0; the mean edge comes out within about 15 % of it,
///                     that of fine unstructured meshes a quarter longer
/// @throws support::InputError   if a length is not positive and finite, or for too many tetrahedra
/// @throws std::runtime_error if gmsh fails
core::TetraMesh generate_box(const core::Vector3 &size, double edge_length,
                             BoxTopology topology = BoxTopology::delaunay);

} // namespace livermark::meshes
