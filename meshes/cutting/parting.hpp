#pragma once

#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// A mesh whose nodes are there twice along some faces.
struct PartedMesh {
    std::vector<core::Vector3> points;          ///< (N') those of the mesh first [m]
    std::vector<std::array<int, 4>> tetrahedra; ///< (M)
    std::vector<int> parent_node;               ///< (N') the node before that each is, or is in the place of
    int num_faces = 0;                          ///< how many are parted
};

/// Faces of a mesh by tetrahedron, each from both sides or none.
using Faces = std::vector<std::array<bool, 4>>;

/// Faces between centroids on either side of a blade.
Faces faces_across(const BladeCut &blade, const core::TetraMesh &mesh);

/// Faces on a blade, along which a body was split.
/// @param is_on_cut  (N) nodes on it
Faces faces_on(const BladeCut &blade, const core::TetraMesh &mesh, const std::vector<bool> &is_on_cut);

/// Parts a mesh along faces: around each node, tetrahedra that hang together by other faces have a node of their own.
/// Faces at whose nodes the new surface would be no manifold stay together, and so does the end of a cut, where no node
/// is there twice.
PartedMesh part_along(const core::TetraMesh &mesh, Faces faces);

} // namespace livermark::meshes
