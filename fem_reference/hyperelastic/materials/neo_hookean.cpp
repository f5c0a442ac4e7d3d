#include <Eigen/LU>
#include <cmath>

#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::hyperelastic::materials {

namespace {

double energy(const core::Material &material, const Matrix3 &f) {
    return 0.5 * material.shear_modulus() * (f.squaredNorm() - 3.0 - 2.0 * std::log(f.determinant()));
}

Matrix3 stress(const core::Material &material, const Matrix3 &f) {
    const Matrix3 inverse = f.inverse();
    return material.shear_modulus() * (f - inverse.transpose());
}

Tangent tangent(const core::Material &material, const Matrix3 &f) {
    const double mu = material.shear_modulus();
    const Matrix3 inverse = f.inverse();
    Tangent result = mu * Tangent::Identity();
    // d2 (-ln J) = (dJ dJ^T) / J^2 - d2 J / J
    const double jacobian = f.determinant();
    add_volume_tangent(-mu / jacobian, mu / (jacobian * jacobian), jacobian, inverse, result);
    return result;
}

} // namespace

/// W = mu / 2 (I1 - 3 - 2 ln J) + lambda / 2 (ln J)^2 with I1 = tr(F^T F).
MaterialLaw neo_hookean() {
    return {.name = {},
            .summary = "compressible neo-Hookean",
            .source = "Bonet, Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, eq. 6.27",
            .energy = energy,
            .stress = stress,
            .tangent = tangent,
            .volume = logarithm,
            .volume_modulus = lame_lambda};
}

} // namespace livermark::hyperelastic::materials
