#pragma once

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

/// What a step of springs takes on a body and on this machine.
namespace livermark::studies {

/// A frame of a display [s].
inline constexpr double frame = 1.0 / 60.0;

struct StepCost {
    /// 2 over the highest frequency of the body when nothing is constrained, which bounds it with any constraint from
    /// below: symplectic Euler without damping [s].
    double critical_time_step = 0.0;
    double seconds_per_step = 0.0; ///< processor time of one core [s]
    bool is_on_vector_units =
        true; ///< false where the fast kernels do not know the springs, and plain loops were timed

    /// With the usual margin [s].
    double safe_time_step() const;
    /// Whole steps of a frame, each no longer than that.
    int steps_per_frame() const;
    /// Processor time of these [s].
    double seconds_per_frame() const { return steps_per_frame() * seconds_per_step; }
};

/// Critical step of springs with nothing constrained, as StepCost has it [s].
double critical_time_step(const core::Body &body, const msm::ElasticBody &springs);

/// Finds the step and times real steps of symplectic Euler: the shortest of some, because other programs take turns.
/// @param springs  of the body
StepCost step_cost(const core::Body &body, const msm::ElasticBody &springs);

/// The critical step with selective mass scaling of stiff parts (msm::scale_masses()); the plain one where none is
/// stiff [s].
double scaled_critical_time_step(const core::Body &body, const msm::ElasticBody &springs);

} // namespace livermark::studies
