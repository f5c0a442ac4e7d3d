#pragma once

#include <Eigen/Core>
#include <array>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Columns are the gradients of the barycentric coordinates of the corners 1, 2 and 3 of a tetrahedron [1/m]; that of
/// corner 0 is minus their sum.
Eigen::Matrix3d coordinate_gradients(const TetraMesh &mesh, const std::array<int, 4> &nodes);

/// A point in the coordinates of a tetrahedron.
struct LocatedPoint {
    int tetrahedron = 0;
    Eigen::Vector4d coordinates = Eigen::Vector4d::Zero(); ///< barycentric

    /// Whether the tetrahedron has the point, to a billionth of its size.
    bool is_inside() const;
};

/// A point in the tetrahedron that has it; of a point that none has, in the one where its least coordinate is largest.
LocatedPoint locate(const TetraMesh &mesh, const Vector3 &point);

} // namespace livermark::core
