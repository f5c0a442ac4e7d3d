#pragma once

#include "core/rayleigh_damping.hpp"

/// Rayleigh damping D = alpha M + beta K (equation 4 of Jurnal Teknologi 75, 10.11113/jt.v75.5068) from what can be
/// measured, the damping ratios of modes: zeta = (alpha / omega + beta omega) / 2. core::rayleigh_damping() is the case
/// of one ratio at two frequencies.
namespace livermark::msm {

/// Damping by the mass alone: alpha = 2 zeta omega. Higher modes are damped less.
/// @param ratio  zeta >= 0
/// @param omega  of the mode that has this ratio [rad/s], > 0
/// @throws support::InputError if one of them is not so
core::RayleighDamping mass_proportional_damping(double ratio, double omega);

/// Damping by the stiffness alone: beta = 2 zeta / omega. Higher modes are damped more.
/// @param ratio  zeta >= 0
/// @param omega  of the mode that has this ratio [rad/s], > 0
/// @throws support::InputError if one of them is not so
core::RayleighDamping stiffness_proportional_damping(double ratio, double omega);

/// A ratio at one frequency and another ratio at another:
/// alpha = 2 omega_1 omega_2 (zeta_1 omega_2 - zeta_2 omega_1) / (omega_2^2 - omega_1^2),
/// beta = 2 (zeta_2 omega_2 - zeta_1 omega_1) / (omega_2^2 - omega_1^2).
/// @param ratio_1, ratio_2  zeta >= 0
/// @param omega_1, omega_2  [rad/s], > 0 and different
/// @throws support::InputError if they are not so, or if alpha or beta would be negative: the ratios may not differ by
///         more than the frequencies do
core::RayleighDamping two_mode_damping(double ratio_1, double omega_1, double ratio_2, double omega_2);

} // namespace livermark::msm
