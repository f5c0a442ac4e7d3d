#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// The nodes of a face in ascending order: the same from both sides.
std::array<int, 3> face_key(std::array<int, 3> nodes);

/// @param face  as in tetrahedron_faces
std::array<int, 3> face_key(const std::array<int, 4> &tetrahedron, std::size_t face);

/// A face of a tetrahedron.
struct TetrahedronFace {
    std::array<int, 3> nodes; ///< ascending
    int tetrahedron = 0;
    int face = 0; ///< as in tetrahedron_faces
    auto operator<=>(const TetrahedronFace &) const = default;
};

/// The faces of all tetrahedra in ascending order, so that what two of them share stands side by side.
/// @return shape (4 M)
std::vector<TetrahedronFace> sorted_faces(std::span<const std::array<int, 4>> tetrahedra);

/// The nodes of a face of more than two tetrahedra; nothing if there is none.
/// @param sorted  as above
std::optional<std::array<int, 3>> face_of_too_many(std::span<const TetrahedronFace> sorted);

/// What is on the other side of each face of each tetrahedron.
/// @return shape (M, 4), faces as in tetrahedron_faces: number of a tetrahedron, -1 outside of all
std::vector<std::array<int, 4>> face_neighbours(std::span<const std::array<int, 4>> tetrahedra);

/// The tetrahedra that have each node as a corner, ascending. @return (N)
std::vector<std::vector<int>> tetrahedra_at_nodes(const TetraMesh &mesh);

} // namespace livermark::core
