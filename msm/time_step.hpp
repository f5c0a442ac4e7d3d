#pragma once

#include "core/load_case.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm {

/// How much one step of an integrator can make of an oscillation u'' + 2 zeta omega u' + omega^2 u = 0: the spectral
/// radius of the 2 x 2 matrix that takes (omega u, v) from one time to the next. Above 1 the oscillation grows without
/// bounds. It is found by taking the step, so it holds for every integrator.
/// @param omega          undamped angular frequency [rad/s], > 0
/// @param damping_ratio  zeta, >= 0
/// @param time_step      [s], > 0
double amplification(const Integrator &integrator, double omega, double damping_ratio, double time_step);

/// The largest amplification of all modes whose angular frequencies lie between the two and have the damping ratios
/// that Rayleigh damping gives them.
/// @param lowest, highest  [rad/s], 0 < lowest <= highest
double largest_amplification(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                             double highest, double time_step);

/// The largest step at which no mode grows, where all angular frequencies lie between the two and have the damping
/// ratios that Rayleigh damping gives them.
/// @param lowest, highest  [rad/s], 0 < lowest <= highest
/// @return [s]; infinity for an integrator that is stable at every step, 0 for one that is stable at none
double critical_time_step(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                          double highest);

/// Part of the critical time step that runs take by default: the springs get stiffer as they are stretched.
inline constexpr double default_safety_factor = 0.8;

} // namespace livermark::msm
