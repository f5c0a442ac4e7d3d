#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// Distance from the surface of what a tool takes away [m], negative inside of it.
struct ToolLevel {
    /// Value of a point outside the region of the tool.
    std::function<double(const core::Vector3 &)> at;
    std::vector<double> of_nodes;   ///< (N) of the mesh
    std::vector<bool> is_in_region; ///< (M) the tetrahedra of the region; empty where the tool has none
};

/// @param tool  that takes something away; its region is one of the mesh
ToolLevel tool_level(const CutTool &tool, const core::TetraMesh &mesh);

/// Whole tetrahedra that go: see CutWay::facets.
/// @param tool  that takes something away; its region is one of the mesh
/// @return shape (M)
std::vector<bool> tetrahedra_taken(const CutTool &tool, const core::TetraMesh &mesh);

/// Place where a segment goes through the quadrilateral of a blade: 0 at a, 1 at b; nothing if it does not.
std::optional<double> crossing_of(const BladeCut &blade, const core::Vector3 &a, const core::Vector3 &b);

/// Whether a point is on the side of a blade to which its normal, right-handed about the corners, points.
bool is_above(const BladeCut &blade, const core::Vector3 &point);

/// Smallest distance between the triangles of two surfaces [m]: 0 where they cross, infinity if one has none.
/// @param triangles  corners of each [m], not on one line
double distance_between(std::span<const std::array<core::Vector3, 3>> triangles,
                        std::span<const std::array<core::Vector3, 3>> others);

/// Whether the tool of a cut is one: its numbers are finite, a margin and a thickness are not negative, a normal is not
/// zero, a blade has an area, and the mesh has the region.
/// @throws support::InputError  if it is none
/// @throws CutNotOnBody         if the mesh has no such region
void check_cut(const Cut &cut, const core::TetraMesh &mesh);

} // namespace livermark::meshes
