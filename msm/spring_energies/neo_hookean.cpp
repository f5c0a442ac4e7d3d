#include <Eigen/LU>
#include <cmath>

#include "msm/kernels/energy_kernels.hpp"
#include "msm/spring_energy.hpp"

namespace livermark::msm::spring_energies {

namespace {

using Eigen::Matrix3d;

/// ln det C, from det C - 1 = 2 tr E + 2 ((tr E)^2 - E : E) + 8 det E, which small strains leave all their digits.
double log_determinant(const Matrix3d &strain) {
    const double trace = strain.trace();
    return std::log1p(2.0 * trace + 2.0 * (trace * trace - strain.squaredNorm()) + 8.0 * strain.determinant());
}

Matrix3d inverse_of_c(const Matrix3d &strain) {
    return (Matrix3d::Identity() + 2.0 * strain).inverse();
}

double energy(double shear_modulus, const Matrix3d &strain) {
    const double log = log_determinant(strain);
    return shear_modulus * (strain.trace() - 0.5 * log + 0.125 * log * log);
}

/// I - C^-1 = 2 C^-1 E
Matrix3d stress(double shear_modulus, const Matrix3d &strain) {
    const Matrix3d inverse = inverse_of_c(strain);
    return shear_modulus * (2.0 * inverse * strain + 0.5 * log_determinant(strain) * inverse);
}

Matrix6 stiffness(double shear_modulus, const Matrix3d &strain) {
    const Matrix3d inverse = inverse_of_c(strain);
    const Vector6 trace = components(inverse);
    Matrix6 result = trace * trace.transpose();
    const double factor = 2.0 - log_determinant(strain);
    for (int c = 0; c < 6; ++c)
        result.col(c) += factor * components(inverse * tensor(Vector6::Unit(c)) * inverse);
    return shear_modulus * result;
}

/// J^-2/3 - 1
double isochoric_factor_minus_one(const Matrix3d &strain) {
    return std::expm1(-log_determinant(strain) / 3.0);
}

double isochoric_energy(double shear_modulus, const Matrix3d &strain) {
    const double trace = strain.trace();
    return shear_modulus * (trace + isochoric_factor_minus_one(strain) * (1.5 + trace));
}

/// mu J^-2/3 (I - tr C / 3 C^-1), and I - tr C / 3 C^-1 = 2 C^-1 dev E
Matrix3d isochoric_stress(double shear_modulus, const Matrix3d &strain) {
    const Matrix3d deviator = strain - strain.trace() / 3.0 * Matrix3d::Identity();
    return 2.0 * shear_modulus * (1.0 + isochoric_factor_minus_one(strain)) * inverse_of_c(strain) * deviator;
}

Matrix6 isochoric_stiffness(double shear_modulus, const Matrix3d &strain) {
    const Matrix3d inverse = inverse_of_c(strain);
    const double trace = 3.0 + 2.0 * strain.trace();
    const Vector6 inverse_parts = components(inverse), identity_parts = components(Matrix3d::Identity());
    Matrix6 result = trace / 3.0 * inverse_parts * inverse_parts.transpose() -
                     identity_parts * inverse_parts.transpose() - inverse_parts * identity_parts.transpose();
    for (int c = 0; c < 6; ++c)
        result.col(c) += trace * components(inverse * tensor(Vector6::Unit(c)) * inverse);
    return 2.0 / 3.0 * shear_modulus * (1.0 + isochoric_factor_minus_one(strain)) * result;
}

} // namespace

/// W = mu / 2 (tr C - 3 - ln det C) + lambda / 8 (ln det C)^2, of which W_s is what lambda = mu makes, and g = ln J.
/// Shape is resisted by mu / 2 (J^-2/3 tr C - 3) (Simo and Hughes, Computational Inelasticity, 1998, section 9.2), and
/// what W_s has beside that stays elastic.
SpringEnergy neo_hookean() {
    return {.name = {},
            .summary = "neo-Hookean",
            .source = "Bonet, Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, eq. 6.27",
            .energy = energy,
            .stress = stress,
            .stiffness = stiffness,
            .isochoric_energy = isochoric_energy,
            .isochoric_stress = isochoric_stress,
            .isochoric_stiffness = isochoric_stiffness,
            .volume = logarithm_of_volume,
            .in_kernels = {StrainMeasure::cauchy_green, StrainMeasure::deformation_gradient},
            .kernels = neo_hookean_kernels};
}

} // namespace livermark::msm::spring_energies
