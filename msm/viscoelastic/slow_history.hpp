#pragma once

#include <vector>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::msm {

/// Motion of a body that relaxes under a slow history.
struct FollowedHistory {
    /// At SlowHistory::whole_load_record(), or where it ended; iterations and factors are those of the whole history.
    Equilibrium end;
    double stored_energy = 0.0;          ///< there [J]
    std::vector<core::PathPoint> points; ///< at SlowHistory::times, as far as it came
    int num_steps = 0;                   ///< in time
};

/// Follows LoadCase::slow_history without masses, one step from each time to the next: the stresses of the elastic law
/// are taken to be linear in time over it (RelaxingBody). In the small regime the body is linearised at rest, and a
/// step is one linear system with the stiffness K_e + instant_part() K_s; steps of one length share its factor. In the
/// large regime it is an equilibrium (EquilibriumSearch), and a step without one is taken again in halves. The error at
/// a given time is of second order in the steps.
/// @param body       as it is at once
/// @param problem    with a slow history
/// @param node_mass  shape (N) [kg]
/// @return status not_converged with the points as far as it came
FollowedHistory follow_history(const ElasticBody &body, const core::Problem &problem,
                               const std::vector<double> &node_mass);

} // namespace livermark::msm
