#include "interactive/elements/energies/projections.hpp"

#include <cmath>

namespace livermark::interactive::densities {

namespace {

core::Vector3 product_slopes(const core::Vector3 &s) {
    return {s.y() * s.z(), s.z() * s.x(), s.x() * s.y()};
}

Matrix3 volume_projection(const Matrix3 &f) {
    const auto [u, v, s] = signed_svd(f);
    return u * nearest_of_unit_product(s).asDiagonal() * v.transpose();
}

/// d p / d s of the nearest point p: p = s + n g with g = d(product)/dp, so dp - n (d2 product) dp - g dn = ds and
/// g . dp = 0.
Matrix3 slope_of_nearest(const core::Vector3 &s, const core::Vector3 &p) {
    const core::Vector3 g = product_slopes(p);
    const double n = (p - s).dot(g) / g.squaredNorm();
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (i != j)
                matrix(i, j) = -n * p[3 - i - j];
    matrix.block<3, 1>(0, 3) = -g;
    matrix.block<1, 3>(3, 0) = g.transpose();
    matrix(3, 3) = 0.0;
    return matrix.inverse().topLeftCorner<3, 3>();
}

/// dD/dF: in the frames of U and V, the diagonal follows the nearest point; the rest turns with them.
Tangent volume_projection_tangent(const Matrix3 &f) {
    constexpr double equal = 1e-6;
    const auto [u, v, s] = signed_svd(f);
    const auto p = nearest_of_unit_product(s);
    const Matrix3 slope = slope_of_nearest(s, p);
    Tangent result;
    for (int k = 0; k < 9; ++k) {
        Matrix3 df = Matrix3::Zero();
        df.data()[k] = 1.0;
        const Matrix3 a = u.transpose() * df * v;
        Matrix3 e;
        e.diagonal() = slope * a.diagonal();
        for (int i = 0; i < 3; ++i)
            for (int j = i + 1; j < 3; ++j) {
                const bool are_equal = std::abs(s[i] - s[j]) < equal;
                const double even = are_equal ? slope(i, i) - slope(i, j) : (p[i] - p[j]) / (s[i] - s[j]);
                const double odd = (p[i] + p[j]) / (s[i] + s[j]);
                e(i, j) = 0.5 * (even * (a(i, j) + a(j, i)) + odd * (a(i, j) - a(j, i)));
                e(j, i) = 0.5 * (even * (a(i, j) + a(j, i)) - odd * (a(i, j) - a(j, i)));
            }
        result.col(k) = by_columns(u * e * v.transpose());
    }
    return result;
}

} // namespace

SignedSvd signed_svd(const Matrix3 &f) {
    const Eigen::JacobiSVD<Matrix3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    SignedSvd result{svd.matrixU(), svd.matrixV(), svd.singularValues()};
    for (Matrix3 *const m : {&result.u, &result.v})
        if (m->determinant() < 0.0) {
            m->col(2) = -m->col(2);
            result.s[2] = -result.s[2];
        }
    return result;
}

core::Vector3 nearest_of_unit_product(const core::Vector3 &s) {
    constexpr int max_iterations = 100;
    constexpr double tolerance = 1e-28; // of squares
    core::Vector3 move = core::Vector3::Zero();
    for (int i = 0; i < max_iterations; ++i) {
        const core::Vector3 p = s + move;
        const core::Vector3 g = product_slopes(p);
        const core::Vector3 next = (g.dot(move) - (p.prod() - 1.0)) / g.squaredNorm() * g;
        const double change = (next - move).squaredNorm();
        move = next;
        if (change < tolerance)
            break;
    }
    return s + move;
}

double Projective::value(const Matrix3 &f) const {
    return mu * (f - nearest_rotation(f)).squaredNorm() + 1.5 * lambda * (f - volume_projection(f)).squaredNorm();
}

Matrix3 Projective::stress(const Matrix3 &f) const {
    return 2.0 * mu * (f - rotation(f)) + 3.0 * lambda * (f - volume_projection(f));
}

Tangent Projective::tangent(const Matrix3 &f) const {
    return Corotational{mu, 0.0}.tangent(f) + 3.0 * lambda * (Tangent::Identity() - volume_projection_tangent(f));
}

} // namespace livermark::interactive::densities
