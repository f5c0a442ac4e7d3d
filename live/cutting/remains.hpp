#pragma once

#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::live {

/// What is left of a mesh from which tetrahedra are taken away. Nodes keep their numbers; those that are gone are
/// corners of no tetrahedron.
struct Remains {
    core::TetraMesh mesh;         ///< all nodes; the tetrahedra that are left, in their order, and their boundary
    std::vector<int> tetrahedron; ///< (M) which of the whole mesh these are, ascending
    /// (T) which boundary triangles of the whole mesh these are, ascending; behind them -1 of those in the wound, in
    /// the order of their tetrahedra.
    std::vector<int> facet;
};

/// @param is_gone  shape (M) of the whole mesh, whose boundary triangles are those of its tetrahedra
Remains remains_of(const core::TetraMesh &whole, const std::vector<char> &is_gone);

/// Of each boundary triangle of what is left, whether it is constrained. The wound is free.
/// @param is_constrained  shape (T) of the whole mesh
std::vector<bool> constrained_remains(const Remains &remains, const std::vector<bool> &is_constrained);

/// Area of the wound [m^2].
double wound_area(const Remains &remains);

} // namespace livermark::live
