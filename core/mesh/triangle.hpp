#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// The point of a segment that is nearest to a point [m].
/// @param from, to  its ends, apart
inline Vector3 nearest_of_segment(const Vector3 &from, const Vector3 &to, const Vector3 &point) {
    const Vector3 side = to - from;
    return from + std::clamp((point - from).dot(side) / side.squaredNorm(), 0.0, 1.0) * side;
}

/// The point of a triangle that is nearest to a point [m]: its foot on the plane if that is inside, else the nearest
/// point of the sides.
/// @param corners  not on one line
inline Vector3 nearest_of_triangle(const std::array<Vector3, 3> &corners, const Vector3 &point) {
    const Vector3 area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const Vector3 foot = point - area * area.dot(point - corners[0]) / area.squaredNorm();
    bool is_inside = true;
    Vector3 nearest = corners[0];
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector3 &from = corners[k], &to = corners[(k + 1) % 3];
        is_inside = is_inside && (to - from).cross(foot - from).dot(area) >= 0.0;
        if (const Vector3 candidate = nearest_of_segment(from, to, point);
            (candidate - point).squaredNorm() < (nearest - point).squaredNorm())
            nearest = candidate;
    }
    return is_inside ? foot : nearest;
}

} // namespace livermark::core
