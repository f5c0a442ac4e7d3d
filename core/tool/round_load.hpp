#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Spread of the traction of a round tool: as h(x) = sqrt(1 - |x - m|^2 / a^2), and nothing beyond its rim.
/// (Hertz's contact; K. L. Johnson, Contact Mechanics, 1985, equation 3.39)
struct RoundLoad {
    Vector3 middle = Vector3::Zero(); ///< m [m]
    double radius = 0.0;              ///< a [m], > 0

    /// h at a point, from 0 to 1.
    double height(const Vector3 &point) const;
    bool operator==(const RoundLoad &) const = default;
};

using Corners = std::array<Vector3, 3>; ///< of a triangle [m]

Corners corners_of(const TetraMesh &mesh, int facet);

/// The point of a triangle with these barycentric coordinates [m].
Vector3 point_at(const Corners &corners, const Vector3 &barycentric);

/// Mean of h over a triangle.
double mean_height(const RoundLoad &load, const Corners &corners);

constexpr int triangle_rows = 24; ///< of parts of a triangle, so that of a share at the rim a thousandth is left
constexpr int num_triangle_parts = triangle_rows * triangle_rows;

/// Calls visit(barycentric coordinates of the centroid) for each of the num_triangle_parts parts of a triangle, which
/// are all alike.
template <class Visit> void visit_triangle_parts(Visit visit) {
    const auto part = [&](double i, double j) { visit(Vector3(triangle_rows - i - j, i, j) / triangle_rows); };
    for (int i = 0; i < triangle_rows; ++i)
        for (int j = 0; i + j < triangle_rows; ++j) {
            part(i + 1.0 / 3.0, j + 1.0 / 3.0);
            if (i + j + 1 < triangle_rows)
                part(i + 2.0 / 3.0, j + 2.0 / 3.0);
        }
}

/// Parts of the force on a triangle that its three corners take with linear shape functions; their sum is 1.
/// @param load  nullptr where the traction is the same everywhere
std::array<double, 3> linear_parts(const RoundLoad *load, const Corners &corners);

/// The same with quadratic shape functions: the corners, then the middles of the sides 01, 12 and 20. Where the
/// traction is the same everywhere, the corners take nothing.
std::array<double, 6> quadratic_parts(const RoundLoad *load, const Corners &corners);

/// Means of the traction over the parts of a triangle, over its mean in the whole one: areas times these have the area
/// as their sum.
/// @param load  nullptr where the traction is the same everywhere, and all are 1
std::vector<double> shares_of_parts(const RoundLoad *load, std::span<const Corners> parts);

} // namespace livermark::core
