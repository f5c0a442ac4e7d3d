#pragma once

#include <optional>
#include <vector>

#include "core/modes.hpp"
#include "core/problem.hpp"
#include "msm/dynamics/damping.hpp"
#include "msm/spring_law.hpp"

namespace livermark::studies {

enum class DampingKind { mass, stiffness, rayleigh };

/// How the damping is found.
struct DampingChoice {
    DampingKind kind = DampingKind::rayleigh;
    double ratio = 0.05;
    /// Where a Rayleigh damping has the ratio [Hz], two; those of the first and the twentieth mode if there are none.
    std::vector<double> frequencies;
};

/// What a set of values is like.
struct Spread {
    int number = 0;
    double sum = 0.0, mean = 0.0, median = 0.0, smallest = 0.0, largest = 0.0; ///< in the unit of the values
};

/// @param values  at least one
Spread spread_of(std::vector<double> values);

/// All that a mass-spring model has of numbers, on one body.
struct BodyParameters {
    double volume = 0.0;             ///< [m^3]
    double tumour_volume = 0.0;      ///< of the regions named tumour_... [m^3]
    double mean_young_modulus = 0.0; ///< by volume [Pa]
    Spread node_mass;                ///< [kg]; its sum is the mass of the body
    Spread stiffness;                ///< of the springs [N/m]
    Spread dashpot;                  ///< beta k of the springs [N s/m]
    Spread ground_damper;            ///< alpha m of the nodes [N s/m]
    core::RayleighDamping damping;
    core::Modes modes;                      ///< the lowest
    double largest_angular_frequency = 0.0; ///< [rad/s]
    double critical_time_step = 0.0;        ///< of Runge-Kutta 4 without damping, 2 sqrt 2 / omega_max [s]

    /// [Hz]
    double frequency(int mode) const;
};

/// The part of them that needs nothing but the springs: all but modes, largest frequency and time step.
BodyParameters spring_parameters(const core::Body &body, const core::SpringNetwork &springs,
                                 const core::RayleighDamping &damping);

/// @param problem  a body, constrained as in the load case
/// @throws support::InputError for a damping that cannot be, and where the springs have no modes
BodyParameters body_parameters(const core::Problem &problem, const msm::SpringLaw &law, const DampingChoice &choice);

/// The same mesh with every region named tumour_... made of what the first other region is made of.
/// @return nothing for a body without tumours, or of tumours only
std::optional<core::Body> without_tumours(const core::Body &body);

} // namespace livermark::studies
