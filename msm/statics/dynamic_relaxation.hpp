#pragma once

#include "msm/integrator.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::msm {

struct RelaxationOptions {
    /// Largest accepted norm of the forces out of balance, relative to that of all forces at work.
    double tolerance = 1e-9;
    int max_steps = 100000;
};

/// Cost of a relaxation.
struct Relaxation {
    Equilibrium equilibrium; ///< without the linear solution; num_iterations are steps
    double time_step = 0.0;  ///< [s]
};

/// Where a body comes to rest, found by letting it move under damping (dynamic relaxation): steps of a safe part
/// of the critical length, and damping by the mass, alpha = 2 omega, critical for the mode that the motion is in, with
/// omega^2 = u^T F(u) / u^T M u of the elastic forces F, looked at again after every few steps.
/// (P. Underwood 1983, Dynamic relaxation, in: Computational Methods for Transient Analysis)
/// @param integrator  explicit
/// @param body, positions, conditions  as for find_equilibrium()
/// @return status not_converged after max_steps, diverged where the motion is lost
Relaxation relax(const Integrator &integrator, const ElasticBody &body, const std::vector<core::Vector3> &positions,
                 const NodalConditions &conditions, const RelaxationOptions &options = {});

} // namespace livermark::msm
