#include "tests/ogden.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace livermark::tests {

namespace {

using hyperelastic::Matrix3;
using hyperelastic::Tangent;
using Svd = Eigen::JacobiSVD<Matrix3>;

Svd decompose(const Matrix3 &f) {
    return Svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
}

/// d W_s / d l of one principal stretch l, over 2 mu / a.
double slope(int exponent, double stretch) {
    return std::pow(stretch, exponent - 1) - 1.0 / stretch;
}

/// (s(l) - s(m)) / (l - m) of s = slope, and s'(l) where l = m. With l = g e^h and m = g e^-h,
///     (l^p - m^p) / (l - m) = g^(p - 1) sinh(p h) / sinh(h),
/// which loses no digits as h goes to 0.
double divided_difference(int exponent, double l, double m) {
    const double h = 0.5 * std::log(l / m), p = exponent - 1.0;
    const double ratio = h == 0.0 ? p : std::sinh(p * h) / std::sinh(h);
    return std::pow(l * m, 0.5 * (p - 1.0)) * ratio + 1.0 / (l * m);
}

template <int exponent> double ogden_energy(const core::Material &material, const Matrix3 &f) {
    const double sum = decompose(f).singularValues().array().pow(exponent).sum();
    return 2.0 * material.shear_modulus() / exponent * ((sum - 3.0) / exponent - std::log(f.determinant()));
}

template <int exponent> Matrix3 ogden_stress(const core::Material &material, const Matrix3 &f) {
    const auto svd = decompose(f);
    const Eigen::Vector3d principal =
        svd.singularValues().unaryExpr([](double stretch) { return slope(exponent, stretch); });
    return 2.0 * material.shear_modulus() / exponent * svd.matrixU() * principal.asDiagonal() *
           svd.matrixV().transpose();
}

/// In the principal axes only stretches along an axis, and pairs of shears of two axes i and j, have to do with each
/// other: dP_ij = ((q + s) dF_ij + (q - s) dF_ji) / 2 with q the divided difference and s the quotient of the sums.
/// (R. W. Ogden 1984, Non-linear Elastic Deformations, chapter 6)
template <int exponent> Tangent ogden_tangent(const core::Material &material, const Matrix3 &f) {
    const auto svd = decompose(f);
    const auto &l = svd.singularValues();
    Tangent principal = Tangent::Zero(), axes;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double q = divided_difference(exponent, l[i], l[j]);
            const double s = (slope(exponent, l[i]) + slope(exponent, l[j])) / (l[i] + l[j]);
            principal(3 * i + j, 3 * i + j) = i == j ? q : 0.5 * (q + s);
            if (i != j)
                principal(3 * i + j, 3 * j + i) = 0.5 * (q - s);
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b)
                    axes(3 * a + b, 3 * i + j) = svd.matrixU()(a, i) * svd.matrixV()(b, j);
        }
    return 2.0 * material.shear_modulus() / exponent * axes * principal * axes.transpose();
}

template <int exponent> OgdenLaw ogden(const char *name) {
    auto law = hyperelastic::material_law("neo_hookean");
    law.name = name;
    law.summary = "one-term Ogden";
    law.source = "R. W. Ogden 1972, Proc. R. Soc. Lond. A 328, 567-583";
    law.energy = ogden_energy<exponent>;
    law.stress = ogden_stress<exponent>;
    law.tangent = ogden_tangent<exponent>;
    return {exponent, law};
}

} // namespace

std::vector<OgdenLaw> ogden_laws() {
    return {ogden<-4>("ogden_minus_4"), ogden<-2>("ogden_minus_2"), ogden<2>("ogden_2"), ogden<8>("ogden_8")};
}

} // namespace livermark::tests
