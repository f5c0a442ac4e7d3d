#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// Volume of a tetrahedron and its first derivatives.
struct VolumeGradient {
    double volume;                         ///< V [m^3], signed
    std::array<core::Vector3, 4> gradient; ///< dV/dx_a of the four corners [m^2]
};

/// @param x            positions, 3 i + component for node i [m]
/// @param tetrahedron  node numbers
inline VolumeGradient volume_gradient(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto corner = [&](int a) -> core::Vector3 {
        return x.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[a]));
    };
    const core::Vector3 origin = corner(0);
    const core::Vector3 a = corner(1) - origin, b = corner(2) - origin, c = corner(3) - origin;
    const core::Vector3 first = b.cross(c) / 6.0, second = c.cross(a) / 6.0, third = a.cross(b) / 6.0;
    return {.volume = a.dot(first), .gradient = {-(first + second + third), first, second, third}};
}

/// The derivative of the gradient along displacements u [m^2], if u is in m.
/// @param u  shape (3N) like x
inline std::array<core::Vector3, 4> volume_gradient_change(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                                                           const std::array<int, 4> &tetrahedron) {
    const auto corner = [&](const Eigen::VectorXd &field, int a) -> core::Vector3 {
        return field.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[a])) -
               field.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[0]));
    };
    const core::Vector3 a = corner(x, 1), b = corner(x, 2), c = corner(x, 3);
    const core::Vector3 p = corner(u, 1), q = corner(u, 2), r = corner(u, 3);
    const core::Vector3 first = (q.cross(c) + b.cross(r)) / 6.0, second = (r.cross(a) + c.cross(p)) / 6.0,
                        third = (p.cross(b) + a.cross(q)) / 6.0;
    return {-(first + second + third), first, second, third};
}

/// Second derivatives d2V / dx_a dx_b, rows and columns 3 a + component [m].
Eigen::Matrix<double, 12, 12> volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron);

/// Puts such a block of one tetrahedron where its nodes are in a (3N, 3N) matrix.
void add_block(std::vector<Eigen::Triplet<double>> &entries, const std::array<int, 4> &tetrahedron,
               const Eigen::Matrix<double, 12, 12> &block);

// The strain of a tetrahedron in the lengths of its edges. Six edges are as many as a strain has components, so each
// says all that the other does. What is said of an edge, its stretch q_e in m^2, may be l^2 - l0^2, or, what is the
// same for small strains, 2 l0 (l - l0).

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A vector for each of the six edges, from its first end to the second.
using EdgeVectors = std::array<core::Vector3, 6>;

/// Differences of a field along the edges.
EdgeVectors edge_spans(const std::array<int, 4> &nodes, const Eigen::VectorXd &field);

/// l_e^2 [m^2]
Vector6 squared_lengths(const EdgeVectors &spans);

/// The rates of stretches whose derivative by the span is 2 pull [m^2/s].
Vector6 stretch_rates(const EdgeVectors &pulls, const EdgeVectors &rates);

/// dq_e/dx of the four corners, rows 3 a + component [m]
Eigen::Matrix<double, 12, 6> stretch_slopes(const EdgeVectors &pulls);

/// Pulls the ends of each edge together with tension_e pull_e, tension_e = 2 dU/dq_e [N/m].
void add_tensions(const std::array<int, 4> &nodes, const EdgeVectors &pulls, const Vector6 &tension,
                  Eigen::VectorXd &force);

/// The second derivative of an energy of six spans that do not know of each other, each with its own.
/// @return shape (12, 12) [N/m]
Eigen::Matrix<double, 12, 12> hessian_of_edges(const std::array<Eigen::Matrix3d, 6> &of_span);

/// The matrix D of the strain E = D q, which is Green's where q = l^2 - l0^2, in the orthonormal components E11, E22,
/// E33, sqrt 2 E12, sqrt 2 E23 and sqrt 2 E31: with g the gradients of the barycentric coordinates at rest, E = -1/4
/// sum over edges ij of q_ij (g_i g_j^T + g_j g_i^T). (Delingette 2008, IEEE TVCG 14(2), for triangles)
/// @param rest   positions [m]
/// @param nodes  of a tetrahedron of positive volume
/// @return [1/m^2]
Matrix6 strain_of_stretches(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes);

/// A symmetric tensor from these components, and back.
Eigen::Matrix3d tensor(const Vector6 &of);
Vector6 components(const Eigen::Matrix3d &of);

/// Stress lambda (tr E) I + 2 mu E in the same components, as a matrix that a strain is multiplied with [Pa].
Matrix6 isotropic_stiffness(double lame_lambda, double shear_modulus);

/// Linear elements of Saint Venant and Kirchhoff's material, written as springs along the six edges of each
/// tetrahedron that are coupled to each other: with q_e = l_e^2 - l0_e^2 of edge e,
///   U = sum over tetrahedra of 1/8 sum over e, f of k_ef q_e q_f,   k_ef = V (lambda tr D_e tr D_f + 2 mu D_e : D_f).
/// The six q are the Green strain E of the tetrahedron, E = 1/2 sum over e of q_e D_e with
/// D_ij = -(g_i g_j^T + g_j g_i^T) / 2 and g the gradients of the barycentric coordinates at rest.
/// (Delingette 2008, IEEE TVCG 14(2), for triangles)
/// @param body  at rest, positive volumes
std::shared_ptr<const ElasticTerm> linear_elements(const core::Body &body);

/// The same of a material with a lambda that is no more than a few mu, as ElasticBody::preconditioner of springs around
/// nodes: their shear stiffness is near that of linear elements, but their volumes give way more easily.
std::shared_ptr<const ElasticTerm> elements_of_softer_volume(const core::Body &body);

} // namespace livermark::msm
