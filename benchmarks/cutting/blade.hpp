#pragma once

#include "meshes/cutting/cut.hpp"

namespace livermark::benchmarks {

/// A body that a blade without thickness has parted, 40 mm deep, through the left lobe of a liver from the front.
inline meshes::CutBody parted_by_blade(const core::Body &body) {
    constexpr double x = 0.08, from = -0.048, to = -0.008, low = -0.06, high = 0.08; // [m]
    return meshes::cut(
        body, {.tool = meshes::BladeCut{{core::Vector3(x, from, low), {x, from, high}, {x, to, high}, {x, to, low}}}});
}

} // namespace livermark::benchmarks
