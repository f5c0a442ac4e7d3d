#pragma once

#include <array>
#include <vector>

#include "msm/dynamics/step_parts.hpp"
#include "msm/kernels/layout/fans.hpp"

namespace livermark::msm {

/// All tetrahedra of one material around an edge, as a closed polygon of nodes around it: (axis, node k, node k + 1) is
/// one of them, with the sign of its volume kept, or nothing. Where tetrahedra end, at the surface or at another
/// material, the polygon goes over the start of the axis, with which there is no volume.
struct Star {
    struct Corner {
        int node = 0;
        int tetrahedron = -1; ///< between this and the next node, -1 if there is none
    };
    std::array<int, 2> axis{};
    int part = -1; ///< see StepParts::edge_part
    std::vector<Corner> rim;
};

/// @param links  of the tetrahedra of one part around an edge, at least one
Star star_of(int part, const std::array<int, 2> &axis, std::vector<Link> links);

/// The polygon without tetrahedra that are removed. As one of those that make it, it goes over the start of the axis
/// where some are missing. Otherwise all of its nodes stay, with no volume between.
/// @param is_removed  shape (M), or empty for none
std::vector<Star::Corner> rim_without(const Star &star, const std::vector<char> &is_removed, bool is_polygon);

/// @param parts  with edge_part
/// @return shape (E)
std::vector<Star> stars_around_edges(const StepParts &parts);

} // namespace livermark::msm
