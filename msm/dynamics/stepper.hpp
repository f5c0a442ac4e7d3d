#pragma once

#include "core/load_case.hpp"
#include "core/rayleigh_damping.hpp"
#include "core/solution.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include <functional>
#include <string>
#include <vector>

namespace livermark::msm {

/// Point masses with an elastic energy under dead loads, with unknown 3 i + component for node i:
/// M u'' = f - grad U(x + u) - alpha M v - beta K_m(x + u) v,
/// K_m the material tangent: on springs the last term is axial dashpots of beta k. It is beta K v at rest (Rayleigh
/// damping) and leaves rigid motion alone. Prescribed components stay where the motion starts.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param scaling     of masses in the accelerations; effective_mass, for implicit integrators, has none of it
/// @return of 3N unknowns
EquationOfMotion elastic_motion(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                const core::RayleighDamping &damping, const MassScaling &scaling = {});

/// 1/2 v^T M v [J]
double kinetic_energy(const EquationOfMotion &equation, const State &state);

/// Steps of one length.
struct Stepper {
    StepKernel kernel; ///< the scalar one where the wanted one does not know the body or the integrator
    std::function<void(State &, int num_steps)> take; ///< moves a state on
};

/// Steps of the motion that elastic_motion() describes.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param time_step   h [s], > 0
Stepper make_stepper(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                     const core::RayleighDamping &damping, const Integrator &integrator, double time_step,
                     StepKernel wanted);

struct ObservationOptions {
    /// Length of one run, in evaluations of the acceleration, so that every integrator may work equally long. A step
    /// just above the critical one needs a long run to be found out.
    int num_accelerations = 4000;
    int num_steps = 0; ///< and at least this many steps
    /// A run is unstable if the norm of its displacements gets larger than that of its start by this factor.
    double growth = 10.0;
    /// The steps that are tried are the whole powers of 1 + accuracy, in seconds.
    double accuracy = 0.002;
    MassScaling scaling{}; ///< of the masses
};

/// The step at which real runs stop being stable: a body at rest, without loads, with the components constrained that
/// are constrained, pushed off by a small displacement that is random and always the same. Found by bisection; nothing
/// is linearised, and nothing is known of the integrator but its steps.
/// @param body        at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  which components are constrained; its loads and the values of its displacements are left out
/// @param guess       where to look first [s], > 0; the solution does not depend on it
/// @return the largest step that was tried and stable [s]; infinity if every step up to 1e4 times the guess is, 0 if
///         none down to 1e-4 times the guess is
double observed_time_step(const Integrator &integrator, const ElasticBody &body, const Field &positions,
                          const NodalConditions &conditions, const core::RayleighDamping &damping, double guess,
                          const ObservationOptions &options = {});

/// Explicit time steps of a body: the critical step 2 / omega_max of symplectic Euler without damping, and
/// the time of such a step on the fastest kernel that knows the body, the shortest of a few dozen that are
/// really taken.
/// @param positions   shape (N) [m], where the body is at rest
/// @param conditions  loads, and which components are constrained
/// @param highest     largest_angular_frequency() with these constrained [rad/s]
core::ExplicitSteps explicit_steps(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                   double highest);

/// Steps of the same body where other components are constrained, which changes how long steps are but not how long
/// they take.
/// @param steps    of the body; measured
/// @param highest  with these constrained [rad/s]
core::ExplicitSteps constrained_otherwise(core::ExplicitSteps steps, double highest);

// Rayleigh damping D = alpha M + beta K (equation 4 of Jurnal Teknologi 75, 10.11113/jt.v75.5068) from what can be
// measured, the damping ratios of modes: zeta = (alpha / omega + beta omega) / 2. core::rayleigh_damping() is the case
// of one ratio at two frequencies.

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
