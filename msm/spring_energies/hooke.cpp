#include "msm/kernels/energy_kernels.hpp"
#include "msm/spring_energy.hpp"

namespace livermark::msm::spring_energies {

namespace {

double hooke_energy(double shear_modulus, const Eigen::Matrix3d &strain) {
    const double trace = strain.trace();
    return shear_modulus * (0.5 * trace * trace + strain.squaredNorm());
}

Eigen::Matrix3d hooke_stress(double shear_modulus, const Eigen::Matrix3d &strain) {
    return shear_modulus * (strain.trace() * Eigen::Matrix3d::Identity() + 2.0 * strain);
}

Matrix6 hooke_stiffness(double shear_modulus, const Eigen::Matrix3d & /*strain*/) {
    return isotropic_stiffness(shear_modulus, shear_modulus);
}

Eigen::Matrix3d hooke_deviator(const Eigen::Matrix3d &strain) {
    return strain - strain.trace() / 3.0 * Eigen::Matrix3d::Identity();
}

double hooke_isochoric_energy(double shear_modulus, const Eigen::Matrix3d &strain) {
    return shear_modulus * hooke_deviator(strain).squaredNorm();
}

Eigen::Matrix3d hooke_isochoric_stress(double shear_modulus, const Eigen::Matrix3d &strain) {
    return 2.0 * shear_modulus * hooke_deviator(strain);
}

Matrix6 hooke_isochoric_stiffness(double shear_modulus, const Eigen::Matrix3d & /*strain*/) {
    return isotropic_stiffness(-2.0 / 3.0 * shear_modulus, shear_modulus);
}

} // namespace

/// W = lambda / 2 (tr E)^2 + mu E : E, of which W_s is what lambda = mu makes, and g = J - 1. Shape is
/// resisted by mu dev E : dev E.
SpringEnergy hooke() {
    return {.name = {},
            .summary = "Hooke's law",
            .source = "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)",
            .energy = hooke_energy,
            .stress = hooke_stress,
            .stiffness = hooke_stiffness,
            .isochoric_energy = hooke_isochoric_energy,
            .isochoric_stress = hooke_isochoric_stress,
            .isochoric_stiffness = hooke_isochoric_stiffness,
            .volume = change_of_volume,
            .is_finite = true,
            .in_kernels = {StrainMeasure::elongation},
            .kernels = hooke_kernels};
}

} // namespace livermark::msm::spring_energies
