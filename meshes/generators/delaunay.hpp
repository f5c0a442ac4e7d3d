#pragma once

#include <functional>
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

/// More have no place in a benchmark: references are solved on eight times as many.
inline constexpr double most_tetrahedra = 2e6;

/// Number of regular tetrahedra that fill a volume. Meshes have about as many: body-centred lattices 11 % more, those
/// of Kuhn half as many again.
/// @param side_of_cube  of the same volume [m], which a number holds where it does not hold the volume
/// @param edge_length   [m]
double expected_tetrahedra(double side_of_cube, double edge_length);

/// The same in words, with two digits: "about 16000 tetrahedra".
std::string text_of_expected_tetrahedra(double expected);

/// Refuses a mesh before it is made, which may take hours and all of the memory.
/// @param what  "a box of 0.1 x 0.2 x 0.1 m"
/// @throws support::InputError if more than most_tetrahedra are expected
void check_number_of_tetrahedra(const std::string &what, double side_of_cube, double edge_length);

/// Volume for gmsh to fill with tetrahedra.
struct Solid {
    std::string name;          ///< "box", for messages
    std::string size;          ///< "0.1 x 0.2 x 0.1 m", the same
    double side_of_cube = 0.0; ///< of the same volume [m], which a number holds where it does not hold the volume
    double longest_side = 0.0; ///< [m]
    std::function<void()> add; ///< to gmsh's model, by OpenCASCADE
};

/// Nodes and tetrahedra of a solid, unstructured, and no boundary yet. The same arguments give the same mesh.
/// @param edge_length  wanted [m], > 0
/// @throws support::InputError if there would be so many tetrahedra that gmsh works for days, or a side is too long to
///   calculate with
/// @throws std::runtime_error if gmsh fails
core::TetraMesh delaunay_mesh(const Solid &solid, double edge_length);

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
