#include "interactive/elements/energies/densities.hpp"

#include <Eigen/SVD>

#include "core/semi_definite_part.hpp"

// What Newton's method alone calls: it takes seconds to compile, and each method includes the header.
namespace livermark::interactive::densities {

Tangent determinant_tangent(const Matrix3 &f) {
    Tangent result = Tangent::Zero();
    for (int c = 0; c < 3; ++c) { // cofactor column c is the product of the next two columns of F
        const int a = (c + 1) % 3, b = (c + 2) % 3;
        const auto cross = [](const core::Vector3 &v) {
            Matrix3 m;
            m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
            return m;
        };
        result.block<3, 3>(3 * c, 3 * b) += cross(f.col(a));
        result.block<3, 3>(3 * c, 3 * a) -= cross(f.col(b));
    }
    return result;
}

Tangent semi_definite_part(const Tangent &tangent) {
    return core::semi_definite_part(tangent);
}

Matrix3 nearest_rotation(const Matrix3 &f) {
    const Eigen::JacobiSVD<Matrix3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0.0)
        u.col(2) = -u.col(2);
    return u * svd.matrixV().transpose();
}

// dR = R [w], (tr S - S) w = axial vector of R^T dF.
Tangent Corotational::tangent(const Matrix3 &f) const {
    const Matrix3 r = rotation(f);
    const Matrix3 s = r.transpose() * f;
    const Matrix3 spin = (s.trace() * Matrix3::Identity() - s).inverse();
    Tangent result = 2.0 * mu * Tangent::Identity() + lambda * by_columns(r) * by_columns(r).transpose();
    for (int k = 0; k < 9; ++k) {
        Matrix3 df = Matrix3::Zero();
        df.data()[k] = 1.0;
        const Matrix3 turned = r.transpose() * df;
        const core::Vector3 w =
            spin * core::Vector3(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0), turned(1, 0) - turned(0, 1));
        Matrix3 cross;
        cross << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
        result.col(k) += (lambda * (s.trace() - 3.0) - 2.0 * mu) * by_columns(r * cross);
    }
    return result;
}

Tangent NeoHookean::tangent(const Matrix3 &f) const {
    const double jacobian = f.determinant();
    const double log = std::log(jacobian);
    const auto c = by_columns(cofactors(f));
    return mu * Tangent::Identity() + (lambda * (1.0 - log) + mu) / (jacobian * jacobian) * c * c.transpose() +
           (lambda * log - mu) / jacobian * determinant_tangent(f);
}

Tangent StableNeoHookean::tangent(const Matrix3 &f) const {
    const auto c = by_columns(cofactors(f));
    return mu * Tangent::Identity() + (lambda + mu) * c * c.transpose() +
           ((lambda + mu) * (f.determinant() - 1.0) - mu) * determinant_tangent(f);
}

} // namespace livermark::interactive::densities
