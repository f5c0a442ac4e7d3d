#pragma once

namespace livermark::core {

/// Damping forces D v with D = alpha M + beta K (Rayleigh).
struct RayleighDamping {
    double alpha = 0.0; ///< of the mass [1/s], >= 0
    double beta = 0.0;  ///< of the stiffness [s], >= 0

    /// Damping ratio of a mode, zeta = (alpha / omega + beta omega) / 2.
    /// @param omega  undamped angular frequency of the mode [rad/s], > 0
    double ratio(double omega) const { return 0.5 * (alpha / omega + beta * omega); }
};

/// The damping that has one ratio at two frequencies, less between them and more outside:
/// alpha = 2 zeta omega_1 omega_2 / (omega_1 + omega_2), beta = 2 zeta / (omega_1 + omega_2).
/// @param ratio             zeta >= 0
/// @param omega_1, omega_2  [rad/s], > 0; may be equal
inline RayleighDamping rayleigh_damping(double ratio, double omega_1, double omega_2) {
    return {.alpha = 2.0 * ratio * omega_1 * omega_2 / (omega_1 + omega_2), .beta = 2.0 * ratio / (omega_1 + omega_2)};
}

} // namespace livermark::core
