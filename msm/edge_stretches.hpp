#pragma once

#include <Eigen/Core>
#include <array>

#include "core/tetra_mesh.hpp"
#include "msm/elastic_body.hpp"

/// The strain of a tetrahedron in the lengths of its edges, q_e = l_e^2 - l0_e^2. Six edges are as many as a strain has
/// components, so each says all that the other does.
namespace livermark::msm {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Differences of a field along the six edges.
using EdgeSpans = std::array<core::Vector3, 6>;
EdgeSpans edge_spans(const std::array<int, 4> &nodes, const Eigen::VectorXd &field);

/// l_e^2 [m^2]
Vector6 squared_lengths(const EdgeSpans &spans);

/// The rate of l_e^2 where the ends move apart with `rates` [m^2/s].
Vector6 squared_length_rates(const EdgeSpans &spans, const EdgeSpans &rates);

/// dq_e/dx of the four corners, rows 3 a + component [m]
Eigen::Matrix<double, 12, 6> squared_length_slopes(const EdgeSpans &spans);

/// Pulls the ends of each edge together with tension_e times its span, tension in N/m.
void add_tensions(const std::array<int, 4> &nodes, const EdgeSpans &spans, const Vector6 &tension,
                  Eigen::VectorXd &force);

/// What tensions that stay the same add to the second derivative of the energy when the edges turn.
/// @return shape (12, 12) [N/m]
Eigen::Matrix<double, 12, 12> tension_hessian(const Vector6 &tension);

/// The matrix D of Green's strain E = D q, in the orthonormal components E11, E22, E33, sqrt 2 E12, sqrt 2 E23 and
/// sqrt 2 E31: with g the gradients of the barycentric coordinates at rest, E = -1/4 sum over edges ij of
/// q_ij (g_i g_j^T + g_j g_i^T). (Delingette 2008, IEEE TVCG 14(2), for triangles)
/// @param rest   positions [m]
/// @param nodes  of a tetrahedron of positive volume
/// @return [1/m^2]
Matrix6 strain_of_stretches(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes);

/// Stress lambda (tr E) I + 2 mu E in the same components, as a matrix that a strain is multiplied with [Pa].
Matrix6 isotropic_stiffness(double lame_lambda, double shear_modulus);

} // namespace livermark::msm
