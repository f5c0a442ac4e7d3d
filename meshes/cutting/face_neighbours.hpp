#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// What is on the other side of each face of each tetrahedron.
/// @return shape (M, 4), faces as in core::tetrahedron_faces: number of a tetrahedron, -1 outside of all
std::vector<std::array<int, 4>> face_neighbours(std::span<const std::array<int, 4>> tetrahedra);

/// Node numbers in ascending order: the same from both sides of a face.
std::array<int, 3> face_key(const std::array<int, 4> &tetrahedron, std::size_t face);

/// The tetrahedra that have each node as a corner. @return (N)
std::vector<std::vector<int>> tetrahedra_at_nodes(const core::TetraMesh &mesh);

} // namespace livermark::meshes
