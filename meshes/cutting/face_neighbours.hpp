#pragma once

#include <array>
#include <span>
#include <vector>

namespace livermark::meshes {

/// What is on the other side of each face of each tetrahedron.
/// @return shape (M, 4), faces as in core::tetrahedron_faces: number of a tetrahedron, -1 outside of all
std::vector<std::array<int, 4>> face_neighbours(std::span<const std::array<int, 4>> tetrahedra);

/// Node numbers in ascending order: the same from both sides of a face.
std::array<int, 3> face_key(const std::array<int, 4> &tetrahedron, std::size_t face);

} // namespace livermark::meshes
