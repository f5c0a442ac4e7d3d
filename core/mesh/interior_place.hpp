#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

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

/// What the nodes of linear tetrahedra take of a force of one newton on each place, and also what their displacements
/// are multiplied by in the mean over it.
/// @return shape (K, N); each row has the sum 1
/// @throws std::invalid_argument as points_of()
Eigen::SparseMatrix<double, Eigen::RowMajor> nodal_weights(std::span<const InteriorPlace> places,
                                                           const TetraMesh &mesh);

} // namespace livermark::core
