#pragma once

#include <string>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/generators/surface_mesh.hpp"

namespace livermark::meshes {

/// Newton's iteration, because std::cbrt may round differently elsewhere.
inline double cube_root(double value) {
    double root = 1.0;
    for (int iteration = 0; iteration < 60; ++iteration)
        root -= (root - value / (root * root)) / 3.0;
    return root;
}

/// Largest number of tetrahedra in a benchmark: references are solved on eight times as many.
inline constexpr double most_tetrahedra = 2e6;

/// Number of regular tetrahedra that fill a volume. Meshes have about as many: body-centred lattices 11 % more, those
/// of Kuhn half as many again.
/// @param side_of_cube  of the same volume [m], which a number holds where it does not hold the volume
/// @param edge_length   [m]
double expected_tetrahedra(double side_of_cube, double edge_length);

/// The same in words, with two digits: "about 16000 tetrahedra".
std::string text_of_expected_tetrahedra(double expected);

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

enum class BoxTopology {
    delaunay, ///< unstructured: gmsh, one thread
    /// Bricks with nodes at their corners and in their middle, and tetrahedra around the line from one middle to the
    /// next: the body-centred cubic lattice, the best regular one. At the sides of the box a brick has two to each
    /// square.
    body_centred,
    kuhn ///< six tetrahedra around the same diagonal of every brick (H. W. Kuhn 1960, IBM J. Res. Dev. 4(5))
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

/// Part of a cylinder.
enum class CylinderPart {
    whole,
    quarter ///< between the planes x = 0 and y = 0, x and y positive
};

/// Number of such parts in the whole.
constexpr double number_of(CylinderPart part) {
    return part == CylinderPart::quarter ? 4.0 : 1.0;
}

/// Side of a cube of the same volume as a cylinder or a part of it, whose height counts as an edge at least [m]: see
/// expected_tetrahedra().
double side_of_cube_like_cylinder(double radius, double height, double edge_length,
                                  CylinderPart part = CylinderPart::whole);

/// A cylinder around the z axis from z = 0 to the height, in tetrahedra: one region "solid", and the patches "side",
/// "z_min" and "z_max", and of a quarter "x_min" and "y_min". Unstructured: gmsh, one thread. The same arguments give
/// the same mesh. The side is of flat triangles. Their corners are a little outside of the cylinder, so that the mesh
/// has its volume: then a bar of it is as stiff in tension, and in bending nearly so.
/// @param radius, height  [m], > 0
/// @param edge_length     wanted edge length [m], > 0 and at most the radius
/// @throws support::InputError   if a length is not positive and finite, or the edges are longer than the radius
/// @throws std::runtime_error if gmsh fails
core::TetraMesh generate_cylinder(double radius, double height, double edge_length,
                                  CylinderPart part = CylinderPart::whole);

/// Side of a cube of the same volume as a sphere [m]: see expected_tetrahedra().
double side_of_cube_like_sphere(double radius);

/// A sphere around the origin, as a cylinder above, of the same volume; with the patch "surface".
core::TetraMesh generate_sphere(double radius, double edge_length);

} // namespace livermark::meshes
