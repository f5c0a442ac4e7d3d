#pragma once

#include <functional>
#include <string>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// What gmsh is to fill with tetrahedra.
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

} // namespace livermark::meshes
