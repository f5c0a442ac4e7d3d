#include "msm/edge_stretches.hpp"

#include <cmath>

#include "msm/tetrahedron_volume.hpp"

namespace livermark::msm {

EdgeSpans edge_spans(const std::array<int, 4> &nodes, const Eigen::VectorXd &field) {
    EdgeSpans spans;
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        spans[e] = of_node(field, nodes[j]) - of_node(field, nodes[i]);
    }
    return spans;
}

Vector6 squared_lengths(const EdgeSpans &spans) {
    Vector6 result;
    for (int e = 0; e < 6; ++e)
        result[e] = spans[e].squaredNorm();
    return result;
}

Vector6 squared_length_rates(const EdgeSpans &spans, const EdgeSpans &rates) {
    Vector6 result;
    for (int e = 0; e < 6; ++e)
        result[e] = 2.0 * spans[e].dot(rates[e]);
    return result;
}

Eigen::Matrix<double, 12, 6> squared_length_slopes(const EdgeSpans &spans) {
    Eigen::Matrix<double, 12, 6> slopes = Eigen::Matrix<double, 12, 6>::Zero();
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        slopes.block<3, 1>(3 * i, e) = -2.0 * spans[e];
        slopes.block<3, 1>(3 * j, e) = 2.0 * spans[e];
    }
    return slopes;
}

void add_tensions(const std::array<int, 4> &nodes, const EdgeSpans &spans, const Vector6 &tension,
                  Eigen::VectorXd &force) {
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        of_node(force, nodes[i]) += tension[e] * spans[e];
        of_node(force, nodes[j]) -= tension[e] * spans[e];
    }
}

Eigen::Matrix<double, 12, 12> tension_hessian(const Vector6 &tension) {
    Eigen::Matrix<double, 12, 12> hessian = Eigen::Matrix<double, 12, 12>::Zero();
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        const Eigen::Matrix3d part = tension[e] * Eigen::Matrix3d::Identity();
        hessian.block<3, 3>(3 * i, 3 * i) += part;
        hessian.block<3, 3>(3 * j, 3 * j) += part;
        hessian.block<3, 3>(3 * i, 3 * j) -= part;
        hessian.block<3, 3>(3 * j, 3 * i) -= part;
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

Matrix6 isotropic_stiffness(double lame_lambda, double shear_modulus) {
    Matrix6 result = 2.0 * shear_modulus * Matrix6::Identity();
    result.topLeftCorner<3, 3>().array() += lame_lambda;
    return result;
}

} // namespace livermark::msm
