#pragma once

#include <string>

#include "meshes/io/raw_mesh.hpp"

namespace livermark::meshes {

/// Every node is finite, used, and the only one at its place, other than in the patch "wound": a body that was parted
/// has nodes of both sides there.
/// @throws support::InputError that names the first that is not
void check_nodes(const RawMesh &raw, const std::string &file);

/// There are tetrahedra, every one has four corners and a positive volume, and none is there twice.
/// @throws support::InputError that names the first that is not so
void check_tetrahedra(const RawMesh &raw, const std::string &file);

/// Every face belongs to one or two tetrahedra, every triangle of the file is a face, and the tetrahedra hang together
/// by faces.
/// @throws support::InputError that names the first that is not so
void check_faces(const RawMesh &raw, const std::string &file);

} // namespace livermark::meshes
