#pragma once

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"

namespace livermark::fem_reference {

/// @throws std::invalid_argument if the load case does not have the sizes of the mesh, or names conditions
///   that it does not have
void check_facets(const core::LoadCase &load_case, const core::TetraMesh &mesh);

/// @throws std::invalid_argument if a boundary triangle is not an outer face of the tetrahedra or is given twice
void check_outer_faces(const core::TetraMesh &mesh);

/// Whether the prescribed displacements stop every rigid motion of every part of the body that hangs together.
bool holds_every_part(const core::LoadCase &load_case, const core::TetraMesh &mesh);

} // namespace livermark::fem_reference
