#pragma once

#include <vector>

#include "core/rayleigh_damping.hpp"
#include "msm/elastic_body.hpp"
#include "msm/needle/moving_needle.hpp"

namespace livermark::msm {

/// How a needle is driven in steps.
struct MovingInsertionOptions {
    double speed = 0.01;     ///< of the hand [m/s], > 0
    double time_step = 1e-3; ///< of symplectic Euler [s], > 0
    core::RayleighDamping damping{.alpha = 10.0, .beta = 0.0};
    ForcePrecision precision = ForcePrecision::double_precision;
};

/// What a needle in steps meets. At a record, work of the hand = stored + kinetic + friction + tearing + holding +
/// damping.
struct MovingInsertion {
    core::Insertion record;      ///< `stored` is elastic; forces are means over the steps from record to record
    std::vector<double> kinetic; ///< (J) [J]
    std::vector<double> damping; ///< (J) lost by damping of the masses so far [J]

    /// The largest that the two sides of the balance differ by at a record, over the work that the hand has done until
    /// the tip was at the target.
    double energy_error() const;
};

/// Drives a needle into a body at a given speed and draws it out at the same, with the records of studies::insert():
/// slowly, that is what the needle meets there.
/// @param body  at rest on the mesh; fast kernels know it
/// @throws std::invalid_argument if they do not, or as MovingNeedle
MovingInsertion insert_in_steps(const ElasticBody &body, const core::TetraMesh &mesh, const NodalConditions &conditions,
                                const core::Needle &needle, const MovingInsertionOptions &options);

} // namespace livermark::msm
