#pragma once

#include <vector>

#include "core/load_case.hpp"
#include "core/solution.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

struct ObservationOptions {
    /// How long one run is, in evaluations of the acceleration, so that every integrator may work equally long. A step
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
double observed_time_step(const Integrator &integrator, const ElasticBody &body,
                          const std::vector<core::Vector3> &positions, const NodalConditions &conditions,
                          const core::RayleighDamping &damping, double guess, const ObservationOptions &options = {});

} // namespace livermark::msm
