#pragma once

#include <string>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"

namespace livermark::load_cases {

/// Refuses a body that can move as a whole without any prescribed displacement being in the way: it has no static
/// solution. A rigid motion u(x) = t + w x (x - c) leaves all constrained components alone if it is in the null space
/// of
///   sum over the constrained components i of the nodes x of  a a^T,   a = (e_i, (x - c) x e_i / r)
/// with c the centroid of the constrained nodes and r their root mean square distance from it.
/// @param mesh       num_boundary_triangles facets
/// @param load_case  at least one facet with a prescribed displacement
/// @param file       for the message
/// @throws NotOnBody that says along or about which axis the body can move
void refuse_free_body(const core::TetraMesh &mesh, const core::LoadCase &load_case, const std::string &file);

} // namespace livermark::load_cases
