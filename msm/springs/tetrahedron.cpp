#include "msm/springs/tetrahedron.hpp"

#include <cmath>

namespace livermark::msm {

namespace {

/// Edges from corner 0 to the others.
std::array<core::Vector3, 3> edges_from_first(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto corner = [&](int a) -> core::Vector3 {
        return x.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[a]));
    };
    const core::Vector3 origin = corner(0);
    return {corner(1) - origin, corner(2) - origin, corner(3) - origin};
}

/// The matrix of a x .
Eigen::Matrix3d cross_matrix(const core::Vector3 &a) {
    return (Eigen::Matrix3d() << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0).finished();
}

} // namespace

Eigen::Matrix<double, 12, 12> volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto edges = edges_from_first(x, tetrahedron);
    Eigen::Matrix<double, 12, 12> hessian = Eigen::Matrix<double, 12, 12>::Zero();
    // 6 dV/da = b x c, so that its derivative in b is -[c x] and in c [b x], and so on in a circle.
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3, last = (k + 2) % 3;
        hessian.block<3, 3>(3 * (k + 1), 3 * (next + 1)) = -cross_matrix(edges[last]) / 6.0;
        hessian.block<3, 3>(3 * (k + 1), 3 * (last + 1)) = cross_matrix(edges[next]) / 6.0;
    }
    // A common shift changes nothing.
    for (int k = 1; k < 4; ++k)
        for (int m = 1; m < 4; ++m) {
            hessian.block<3, 3>(0, 3 * m) -= hessian.block<3, 3>(3 * k, 3 * m);
            hessian.block<3, 3>(3 * k, 0) -= hessian.block<3, 3>(3 * k, 3 * m);
        }
    for (int k = 1; k < 4; ++k)
        hessian.block<3, 3>(0, 0) -= hessian.block<3, 3>(3 * k, 0);
    return hessian;
}

void add_block(std::vector<Eigen::Triplet<double>> &entries, const std::array<int, 4> &tetrahedron,
               const Eigen::Matrix<double, 12, 12> &block) {
    for (int row = 0; row < 12; ++row)
        for (int column = 0; column < 12; ++column)
            entries.emplace_back(3 * tetrahedron[row / 3] + row % 3, 3 * tetrahedron[column / 3] + column % 3,
                                 block(row, column));
}

EdgeVectors edge_spans(const std::array<int, 4> &nodes, const Eigen::VectorXd &field) {
    EdgeVectors spans;
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        spans[e] = of_node(field, nodes[j]) - of_node(field, nodes[i]);
    }
    return spans;
}

Vector6 squared_lengths(const EdgeVectors &spans) {
    Vector6 result;
    for (int e = 0; e < 6; ++e)
        result[e] = spans[e].squaredNorm();
    return result;
}

Vector6 stretch_rates(const EdgeVectors &pulls, const EdgeVectors &rates) {
    Vector6 result;
    for (int e = 0; e < 6; ++e)
        result[e] = 2.0 * pulls[e].dot(rates[e]);
    return result;
}

Eigen::Matrix<double, 12, 6> stretch_slopes(const EdgeVectors &pulls) {
    Eigen::Matrix<double, 12, 6> slopes = Eigen::Matrix<double, 12, 6>::Zero();
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        slopes.block<3, 1>(3 * i, e) = -2.0 * pulls[e];
        slopes.block<3, 1>(3 * j, e) = 2.0 * pulls[e];
    }
    return slopes;
}

void add_tensions(const std::array<int, 4> &nodes, const EdgeVectors &pulls, const Vector6 &tension,
                  Eigen::VectorXd &force) {
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        of_node(force, nodes[i]) += tension[e] * pulls[e];
        of_node(force, nodes[j]) -= tension[e] * pulls[e];
    }
}

Eigen::Matrix<double, 12, 12> hessian_of_edges(const std::array<Eigen::Matrix3d, 6> &of_span) {
    Eigen::Matrix<double, 12, 12> hessian = Eigen::Matrix<double, 12, 12>::Zero();
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        hessian.block<3, 3>(3 * i, 3 * i) += of_span[e];
        hessian.block<3, 3>(3 * j, 3 * j) += of_span[e];
        hessian.block<3, 3>(3 * i, 3 * j) -= of_span[e];
        hessian.block<3, 3>(3 * j, 3 * i) -= of_span[e];
    }
    return hessian;
}

Matrix6 strain_of_stretches(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes) {
    const auto [volume, gradient] = volume_gradient(rest, nodes);
    Matrix6 result;
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        const core::Vector3 a = gradient[i] / volume;
        const core::Vector3 b = gradient[j] / volume;
        for (int c = 0; c < 3; ++c) {
            const int d = (c + 1) % 3;
            result(c, e) = -0.5 * a[c] * b[c];
            result(3 + c, e) = -0.25 * std::sqrt(2.0) * (a[c] * b[d] + a[d] * b[c]);
        }
    }
    return result;
}

Eigen::Matrix3d tensor(const Vector6 &of) {
    const double xy = std::sqrt(0.5) * of[3], yz = std::sqrt(0.5) * of[4], zx = std::sqrt(0.5) * of[5];
    return (Eigen::Matrix3d() << of[0], xy, zx, xy, of[1], yz, zx, yz, of[2]).finished();
}

Vector6 components(const Eigen::Matrix3d &of) {
    Vector6 result;
    result << of(0, 0), of(1, 1), of(2, 2), std::sqrt(2.0) * of(0, 1), std::sqrt(2.0) * of(1, 2),
        std::sqrt(2.0) * of(2, 0);
    return result;
}

Matrix6 isotropic_stiffness(double lame_lambda, double shear_modulus) {
    Matrix6 result = 2.0 * shear_modulus * Matrix6::Identity();
    result.topLeftCorner<3, 3>().array() += lame_lambda;
    return result;
}

} // namespace livermark::msm
