#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/spring_law.hpp"

namespace livermark::msm {

/// The springs of a body: an edge of the mesh each, at rest in the mesh.
core::SpringNetwork spring_network(const core::Body &body, const SpringLaw &law);

/// Elastic energy, U = sum over springs of k (l - l0)^2 / 2.
/// @param positions  shape (N) [m]
/// @return [J]
double elastic_energy(const core::SpringNetwork &springs, const std::vector<core::Vector3> &positions);

/// Gradient of the elastic energy: the force that holds each node where it is. The slow, obvious kernel; every fast one
/// is tested against it.
/// @param positions  shape (N) [m], no two ends of a spring in one place
/// @return shape (N) [N]
std::vector<core::Vector3> elastic_gradient(const core::SpringNetwork &springs,
                                            const std::vector<core::Vector3> &positions);

/// What of the second derivative to keep.
enum class Tangent {
    exact,         ///< k [n n^T + (1 - l0/l) (I - n n^T)]
    semi_definite, ///< the same without the part that compressed springs make negative
    axial          ///< k n n^T, along the springs alone
};

/// Second derivative of the elastic energy, rows and columns 3 i + component.
/// @param positions  shape (N) [m]
/// @return shape (3N, 3N) [N/m], both triangles
Eigen::SparseMatrix<double> elastic_hessian(const core::SpringNetwork &springs,
                                            const std::vector<core::Vector3> &positions, Tangent tangent);

} // namespace livermark::msm
