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

/// Cuts of the bricks of a lattice into tetrahedra.
enum class Lattice {
    /// Nodes at the corners and in the middle of bricks, and tetrahedra around the line from one middle to the next:
    /// the
    /// body-centred cubic lattice, the best regular one. At the sides of the box a brick has two to each square.
    body_centred,
    /// Six tetrahedra around the same diagonal of every brick. (H. W. Kuhn 1960, IBM J. Res. Dev. 4(5))
    kuhn
};

/// Points and tetrahedra of a box [0, a] x [0, b] x [0, c], and nothing else; the bricks are as close to cubes as a
/// whole number of them can be.
/// @param size       a, b, c [m], > 0
/// @param mean_edge  wanted mean length of the edges inside [m], > 0
///                   and so long that node numbers can count the bricks: see check_number_of_tetrahedra()
core::TetraMesh lattice_box(const core::Vector3 &size, double mean_edge, Lattice lattice);

} // namespace livermark::meshes
