#pragma once

#include <vector>

#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// A body whose tetrahedra are split where a cut goes through them. Its volume is that of the body before, to rounding.
struct SplitBody {
    core::Body body;
    std::vector<int> parent_tetrahedron; ///< (M') ascending
    std::vector<bool> is_on_cut;         ///< (N') nodes on the surface of the cut
    std::vector<bool> taken;             ///< (M') what is inside of what the tool takes away
};

/// Splits tetrahedra along the surface of what a tool takes away, so that each part is inside or outside. A blade
/// thinner than the edges is met by a node on its middle surface in each edge that goes through.
/// @param tool  that takes something away; its region is one of the mesh
SplitBody split_along(const core::Body &body, const CutTool &tool);

/// Splits tetrahedra along a blade without thickness; nothing is taken.
SplitBody split_along_blade(const core::Body &body, const BladeCut &blade);

} // namespace livermark::meshes
