#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Points of contact on a facet with straight sides.
struct FacetPoint {
    std::array<double, 3> shape{}; ///< values of the linear shape functions of its corners; they sum to 1
    double part = 0.0;             ///< of the area of the facet; those of all points sum to 1
};

/// The points of a quadrature: the facet is divided into k^2 equal triangles, and each of these has seven points, exact
/// to degree 5. The rule is the same in whatever order the corners are. (J. Radon 1948, Zur mechanischen Kubatur,
/// Monatsh. Math. 52)
/// @param divisions  k of each side, > 0
std::vector<FacetPoint> facet_points(int divisions);

/// Columns are the gradients of the barycentric coordinates of the corners 1, 2 and 3 of a tetrahedron [1/m]; that of
/// corner 0 is minus their sum.
Eigen::Matrix3d coordinate_gradients(const TetraMesh &mesh, const std::array<int, 4> &nodes);

/// Slopes of the barycentric coordinates of a tetrahedron along a direction of length 1 [1/m].
Eigen::Vector4d coordinate_slopes(const TetraMesh &mesh, const std::array<int, 4> &nodes, const Vector3 &direction);

/// A point in the coordinates of a tetrahedron.
struct LocatedPoint {
    int tetrahedron = 0;
    Eigen::Vector4d coordinates = Eigen::Vector4d::Zero(); ///< barycentric

    /// Whether the tetrahedron has the point, to a billionth of its size.
    bool is_inside() const;
};

/// A point in the tetrahedron that has it; of a point that none has, in the one where its least coordinate is largest.
LocatedPoint locate(const TetraMesh &mesh, const Vector3 &point);

/// A place inside a body, whatever its mesh: what acts there is spread over a ball, and what is read there is a mean
/// over it, both with the weight w(x) = (1 - |x - m|^2 / r^2)^2 in the part of the ball that is in the body, divided by
/// its integral. So both have a limit as meshes are refined.
struct InteriorPlace {
    Vector3 middle = Vector3::Zero(); ///< m [m]
    double radius = 0.0;              ///< r [m], > 0
};

/// A point of a tetrahedron and its part of a place.
struct PlacePoint {
    int tetrahedron = 0;
    Eigen::Vector4d barycentric = Eigen::Vector4d::Zero();
    double weight = 0.0; ///< > 0; the sum over a place is 1
};

/// The points of a quadrature of a place's weight.
/// @throws std::invalid_argument if no point of the body is in the ball
std::vector<PlacePoint> points_of(const InteriorPlace &place, const TetraMesh &mesh);

/// Parts that the nodes of linear tetrahedra take of a force of one newton on each place, and also what their
/// displacements are multiplied by in the mean over it.
/// @return shape (K, N); each row has the sum 1
/// @throws std::invalid_argument as points_of()
Eigen::SparseMatrix<double, Eigen::RowMajor> nodal_weights(std::span<const InteriorPlace> places,
                                                           const TetraMesh &mesh);

/// Changes that displacements of the nodes make to a mesh, with straight edges between them.
struct Deformation {
    double volume_change = 0.0;     ///< (v - V) / V of the whole body
    double smallest_jacobian = 0.0; ///< least ratio of the volumes of a tetrahedron, after and before
    int num_inverted = 0;           ///< tetrahedra whose volume is not positive any more
    std::vector<Vector3> centroid;  ///< (R) of each region, where it is now [m]
};

/// @param displacement  shape (N) [m]; what is not finite gives figures that are not finite, and counts as inverted
/// @throws std::invalid_argument if it has another size
Deformation deformation(const TetraMesh &mesh, std::span<const Vector3> displacement);

} // namespace livermark::core
