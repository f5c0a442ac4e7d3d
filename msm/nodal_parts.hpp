#pragma once

#include <array>
#include <cstddef>
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

/// Part of what is in a tetrahedron that the part around one of its corners has, V_t / (4 V_c).
/// @param tetrahedron  with its volume [m^3]
template <class Tetrahedron>
double share_of_part(const Tetrahedron &tetrahedron, int part, const std::vector<double> &part_volume) {
    return 0.25 * tetrahedron.volume / part_volume[part];
}

/// Means over the parts around nodes of what is constant in tetrahedra.
/// @param tetrahedra   (M) each with its volume [m^3], and the parts around its corners
/// @param part_volume  (C) [m^3]
/// @param values       (M) matrices or vectors of Eigen of a fixed size
/// @return (C)
template <class Tetrahedron, class Value>
std::vector<Value> nodal_means(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &part_volume,
                               const std::vector<Value> &values) {
    std::vector<Value> mean(part_volume.size(), Value::Zero());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (const int part : tetrahedra[t].parts)
            mean[part] += share_of_part(tetrahedra[t], part, part_volume) * values[t];
    return mean;
}

} // namespace livermark::msm
