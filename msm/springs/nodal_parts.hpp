#pragma once

#include <array>
#include <vector>

#include "core/problem.hpp"

namespace livermark::msm {

/// The part of a body around each node, one for each material at it, with a quarter of each of its tetrahedra there.
/// Where two materials meet stress and pressure jump, so each has its own.
struct NodalParts {
    std::vector<int> node;                     ///< (C) in the middle
    std::vector<int> region;                   ///< (C)
    std::vector<double> volume;                ///< (C) at rest [m^3]
    std::vector<std::array<int, 4>> at_corner; ///< (M) part around each corner of a tetrahedron
    std::vector<double> tetrahedron_volume;    ///< (M) at rest [m^3]
};

/// @param body  at rest, positive volumes
NodalParts nodal_parts(const core::Body &body);

} // namespace livermark::msm
