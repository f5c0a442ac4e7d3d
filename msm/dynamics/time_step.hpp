#pragma once

#include "core/load_case.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm {

/// Whether an oscillation u'' + 2 zeta omega u' + omega^2 u = 0 stays within bounds: whether both eigenvalues of the 2
/// x 2 matrix that takes (omega u, v) from one time to the next lie in the unit circle. The matrix is found by taking
/// the step, so this holds for every integrator.
/// @param omega          undamped angular frequency [rad/s], > 0
/// @param damping_ratio  zeta, >= 0
/// @param time_step      [s], > 0
bool is_stable(const Integrator &integrator, double omega, double damping_ratio, double time_step);

/// What one step makes of the fastest growing oscillation at most, where angular frequencies and damping ratios are as
/// in critical_time_step(): the largest modulus of an eigenvalue of that matrix. For steps that are clearly stable or
/// not; near 1 half the digits may be lost, so is_stable() does not ask it.
double largest_amplification(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                             double highest, double time_step);

/// The largest step at which no mode grows, where all angular frequencies lie between the two and have the damping
/// ratios that Rayleigh damping gives them.
/// @param lowest, highest  [rad/s], 0 < lowest <= highest
/// @return [s]; infinity for an integrator that is stable at every step, 0 for one that is stable at none
double critical_time_step(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                          double highest);

/// Lowest frequency at which runs look at the damping, as a part of the highest.
inline constexpr double lowest_damped_part = 1e-3;

/// Part of the critical time step that runs take by default: the springs get stiffer as they are stretched.
inline constexpr double default_safety_factor = 0.8;

} // namespace livermark::msm
