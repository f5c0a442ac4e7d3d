#pragma once

#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/cut.hpp"

/// A body that a blade without thickness parts: along faces of its tetrahedra, whose nodes go to the blade.
namespace livermark::live {

struct Remains;

/// Place of a node in the body before: between the nodes of a tetrahedron there.
struct PlaceBefore {
    std::array<int, 4> nodes;
    std::array<double, 4> weight; ///< of these; they add up to one
};

/// Distances of a wound from the blade that has made it [m].
struct OffBlade {
    double mean = 0.0;  ///< over the area
    double worst = 0.0; ///< of all nodes
};

struct PartedBody {
    core::TetraMesh mesh;            ///< see parted_mesh(): the whole body at rest
    std::vector<PlaceBefore> before; ///< (N') of each node
    std::vector<int> parent_node;    ///< (N') the node before that each is, or is parted from
    std::vector<int> changed;        ///< tetrahedra that have other nodes or another shape, ascending
    double area = 0.0;               ///< of one side of the wound, at rest [m^2]
    OffBlade jagged, snapped;        ///< of the wound, before its nodes went to the blade and after
};

/// A mesh of which some tetrahedra have other nodes, in other places. Tetrahedra keep their numbers and so do boundary
/// triangles; behind these come the faces that are parted, in the order of their tetrahedra, as core::wound_patch.
/// @param original    before any parting
/// @param points      shape (N'), those of `original` first, at rest [m]
/// @param tetrahedra  shape (M)
core::TetraMesh parted_mesh(const core::TetraMesh &original, std::vector<core::Vector3> points,
                            std::vector<std::array<int, 4>> tetrahedra);

/// Parts a body along the faces between tetrahedra with their centroids on either side of a blade, as
/// meshes::part_along() does, and moves the nodes of these faces onto the blade: those of the capsule along the
/// capsule, those inside straight. Nodes that are constrained and those between regions stay. A node goes as far as its
/// tetrahedra keep 0.3 of their smallest height and 0.7 of the smallest one in the body. Then faces are chosen again.
/// @param original        before any parting
/// @param whole           the whole mesh now
/// @param before          what earlier cuts have left of it
/// @param is_constrained  shape (N), nodes
/// @param displacement    shape (N), where the body is [m]: there the blade meets it
/// @throws support::InputError if the blade parts nothing
PartedBody part_body(const core::TetraMesh &original, const core::TetraMesh &whole, const Remains &before,
                     const std::vector<bool> &is_constrained, const std::vector<core::Vector3> &displacement,
                     const meshes::BladeCut &blade);

} // namespace livermark::live
