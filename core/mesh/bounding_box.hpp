#pragma once

#include <Eigen/Geometry>
#include <span>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// The smallest box along the axes that holds all points [m]; empty if there are none.
inline Eigen::AlignedBox3d bounding_box(std::span<const Vector3> points) {
    Eigen::AlignedBox3d box;
    for (const auto &point : points)
        box.extend(point);
    return box;
}

/// Diagonal of the box around some points [m].
/// @param points  at least one
inline double extent(std::span<const Vector3> points) {
    return bounding_box(points).diagonal().norm();
}

} // namespace livermark::core
