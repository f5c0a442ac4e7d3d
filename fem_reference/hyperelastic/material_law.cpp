#include "fem_reference/hyperelastic/material_law.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace livermark::hyperelastic {

const MaterialLaw &material_law(const std::string &name) {
    const auto laws = all_materials();
    const auto found = std::ranges::find(laws, name, &MaterialLaw::name);
    if (found != laws.end())
        return *found;
    std::string names;
    for (const auto &law : laws)
        names += (names.empty() ? "" : ", ") + law.name;
    throw std::invalid_argument("there is no hyperelastic material " + name + "; choose one of " + names);
}

bool has_constants(const MaterialLaw &law, const core::Material &material) {
    const auto found = material.law_constants.find(law.name);
    return law.num_constants == 0 ||
           (found != material.law_constants.end() && found->second.size() == law.num_constants);
}

IsochoricInvariant isochoric_invariant(const Matrix3 &f) {
    const Matrix3 inverse = f.inverse();
    const double scale = std::pow(f.determinant(), -2.0 / 3.0), invariant = f.squaredNorm();
    IsochoricInvariant found{scale * invariant - 3.0, scale * (2.0 * f - 2.0 / 3.0 * invariant * inverse.transpose()),
                             Tangent(2.0 * scale * Tangent::Identity())};
    for (int i = 0; i < 3; ++i)
        for (int big_j = 0; big_j < 3; ++big_j)
            for (int j = 0; j < 3; ++j)
                for (int big_l = 0; big_l < 3; ++big_l)
                    found.second(3 * i + big_j, 3 * j + big_l) +=
                        scale * (-4.0 / 3.0 * (f(i, big_j) * inverse(big_l, j) + inverse(big_j, i) * f(j, big_l)) +
                                 invariant * (4.0 / 9.0 * inverse(big_j, i) * inverse(big_l, j) +
                                              2.0 / 3.0 * inverse(big_l, i) * inverse(big_j, j)));
    return found;
}

void add_volume_tangent(double factor, double outer, double jacobian, const Matrix3 &inverse, Tangent &tangent) {
    // d J / d F_iJ = J G_Ji
    const double for_products = factor * jacobian + outer * jacobian * jacobian;
    const double for_swapped = -factor * jacobian;
    for (int i = 0; i < 3; ++i)
        for (int big_j = 0; big_j < 3; ++big_j)
            for (int j = 0; j < 3; ++j)
                for (int big_l = 0; big_l < 3; ++big_l)
                    tangent(3 * i + big_j, 3 * j + big_l) += for_products * inverse(big_j, i) * inverse(big_l, j) +
                                                             for_swapped * inverse(big_l, i) * inverse(big_j, j);
}

namespace {

/// F = U diag(l) V^T by way of F^T F: as exact as a singular value decomposition as long as the stretches are of one
/// size, and faster.
struct Stretches {
    explicit Stretches(const Matrix3 &f) {
        const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(f.transpose() * f);
        stretch = eigen.eigenvalues().cwiseSqrt();
        right = eigen.eigenvectors();
        left = f * right * stretch.cwiseInverse().asDiagonal();
    }
    Eigen::Vector3d stretch; ///< l
    Matrix3 left, right;     ///< U, V
};

/// d W_s / d l of one principal stretch l, over 2 mu / a.
double stretch_slope(double exponent, double stretch) {
    return std::pow(stretch, exponent - 1.0) - 1.0 / stretch;
}

/// (s(l) - s(m)) / (l - m) of s = stretch_slope, and s'(l) where l = m. With l = g e^h and m = g e^-h,
///     (l^p - m^p) / (l - m) = g^(p - 1) sinh(p h) / sinh(h),
/// which loses no digits as h goes to 0.
double divided_difference(double exponent, double l, double m) {
    const double h = 0.5 * std::log(l / m), p = exponent - 1.0;
    const double ratio = h == 0.0 ? p : std::sinh(p * h) / std::sinh(h);
    return std::pow(l * m, 0.5 * (p - 1.0)) * ratio + 1.0 / (l * m);
}

} // namespace

double OgdenTerm::energy(const Matrix3 &f) const {
    const double sum = Stretches(f).stretch.array().pow(exponent).sum();
    return 2.0 * shear_modulus / exponent * ((sum - 3.0) / exponent - std::log(f.determinant()));
}

Matrix3 OgdenTerm::stress(const Matrix3 &f) const {
    const Stretches of(f);
    const Eigen::Vector3d principal =
        of.stretch.unaryExpr([&](double stretch) { return stretch_slope(exponent, stretch); });
    return 2.0 * shear_modulus / exponent * of.left * principal.asDiagonal() * of.right.transpose();
}

/// In the principal axes only stretches along an axis, and pairs of shears of two axes i and j, have to do with each
/// other: dP_ij = ((q + s) dF_ij + (q - s) dF_ji) / 2 with q the divided difference and s the quotient of the sums.
/// (R. W. Ogden 1984, Non-linear Elastic Deformations, chapter 6)
Tangent OgdenTerm::tangent(const Matrix3 &f) const {
    const Stretches of(f);
    const auto &l = of.stretch;
    const Eigen::Vector3d slope = l.unaryExpr([&](double stretch) { return stretch_slope(exponent, stretch); });
    Tangent principal = Tangent::Zero(), axes;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) {
            const int ij = 3 * i + j, ji = 3 * j + i;
            const double q = divided_difference(exponent, l[i], l[j]), s = (slope[i] + slope[j]) / (l[i] + l[j]);
            principal(ij, ij) = principal(ji, ji) = i == j ? q : 0.5 * (q + s);
            if (i != j)
                principal(ij, ji) = principal(ji, ij) = 0.5 * (q - s);
        }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b)
                    axes(3 * a + b, 3 * i + j) = of.left(a, i) * of.right(b, j);
    return 2.0 * shear_modulus / exponent * axes * principal * axes.transpose();
}

} // namespace livermark::hyperelastic
