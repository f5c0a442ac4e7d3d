#include "tests/samples/calculix_neo_hooke.hpp"

#include <Eigen/LU>
#include <cmath>

namespace livermark::tests {

namespace {

using hyperelastic::Matrix3;
using hyperelastic::Tangent;

double energy(const core::Material &material, const Matrix3 &f) {
    return 0.5 * material.shear_modulus() * (std::pow(f.determinant(), -2.0 / 3.0) * f.squaredNorm() - 3.0);
}

Matrix3 stress(const core::Material &material, const Matrix3 &f) {
    const Matrix3 inverse = f.inverse();
    return material.shear_modulus() * std::pow(f.determinant(), -2.0 / 3.0) *
           (f - f.squaredNorm() / 3.0 * inverse.transpose());
}

Tangent tangent(const core::Material &material, const Matrix3 &f) {
    const Matrix3 inverse = f.inverse();
    const double first = f.squaredNorm();
    Tangent result;
    for (int i = 0; i < 3; ++i)
        for (int m = 0; m < 3; ++m)
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    result(3 * i + m, 3 * j + l) = (i == j && m == l ? 1.0 : 0.0) -
                                                   2.0 / 3.0 * (f(i, m) * inverse(l, j) + inverse(m, i) * f(j, l)) +
                                                   2.0 / 9.0 * first * inverse(m, i) * inverse(l, j) +
                                                   first / 3.0 * inverse(l, i) * inverse(m, j);
    return material.shear_modulus() * std::pow(f.determinant(), -2.0 / 3.0) * result;
}

hyperelastic::VolumeMeasure volume(double jacobian) {
    return {jacobian - 1.0, 1.0, 0.0};
}

double volume_modulus(const core::Material &material) {
    return material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus();
}

} // namespace

hyperelastic::MaterialLaw calculix_neo_hooke() {
    return {.name = "calculix_neo_hooke",
            .summary = "neo-Hookean as CalculiX has it",
            .source = "CalculiX CrunchiX User's Manual",
            .energy = energy,
            .stress = stress,
            .tangent = tangent,
            .volume = volume,
            .volume_modulus = volume_modulus};
}

} // namespace livermark::tests
