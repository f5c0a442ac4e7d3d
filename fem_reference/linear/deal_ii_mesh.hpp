#pragma once

#include <deal.II/grid/tria.h>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::fem_reference {

/// Gives a mesh to deal.II, which keeps its node, tetrahedron and local vertex order.
/// @param triangulation  empty
void fill(dealii::Triangulation<3> &triangulation, const core::TetraMesh &mesh);

/// The same, for what does not see deal.II: matrices of one mesh share what deal.II works out of it.
struct DealIiMesh {
    explicit DealIiMesh(const core::TetraMesh &mesh) { fill(triangulation, mesh); }

    dealii::Triangulation<3> triangulation;
};

} // namespace livermark::fem_reference
