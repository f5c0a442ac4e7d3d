#pragma once

#include <vector>

#include "core/tetra_mesh.hpp"

namespace livermark::msm {

/// Diagonal of the box around some positions [m].
/// @param positions  at least one
inline double extent(const std::vector<core::Vector3> &positions) {
    core::Vector3 low = positions.front(), high = low;
    for (const auto &x : positions) {
        low = low.cwiseMin(x);
        high = high.cwiseMax(x);
    }
    return (high - low).norm();
}

} // namespace livermark::msm
