#pragma once

#include <vector>

#include "core/tool/round_load.hpp"

/// How a tool with a round end presses on a place. Its pressure vanishes at the rim, and the force on a tool that is
/// pushed in hardly changes when the rim moves, so that it matters little where the facets of a mesh end. A flat tool
/// has a pressure without bound at its rim, which every mesh resolves in another way. (Hertz's contact; K. L. Johnson,
/// Contact Mechanics, 1985, equations 3.39 and 3.41)
namespace livermark::load_cases {

/// (N) parts of the depth of the middle to which the nodes of a place are pushed: the function that is linear on its
/// facets and nearest to 1 - (r/a)^2 / 2, and not below 0, in the mean square over their area. Values at the nodes
/// alone would make the place too shallow between them, the more so the coarser the mesh is. 1 at all other nodes.
std::vector<double> sinking(const core::RoundLoad &tool, const core::TetraMesh &mesh, const std::vector<int> &facets);

} // namespace livermark::load_cases
