#include "studies/advise/step_cost.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/processor_time.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::studies {

namespace {

/// As many steps as fit into this time are taken, within these numbers [s].
constexpr double timing_seconds = 0.25;
constexpr int least_timed_steps = 5, most_timed_steps = 200;

msm::NodalConditions nothing_constrained(std::size_t num_nodes) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {.displacement = std::vector<core::Vector3>(num_nodes, core::Vector3::Constant(nan)),
            .constraint = std::vector<std::array<int, 3>>(num_nodes, {-1, -1, -1}),
            .force = std::vector<core::Vector3>(num_nodes, core::Vector3::Zero())};
}

double shortest_time(const std::function<void()> &step) {
    double shortest = std::numeric_limits<double>::infinity(), sum = 0.0;
    for (int s = 0; s < most_timed_steps && (s < least_timed_steps || sum < timing_seconds); ++s) {
        const double start = core::processor_seconds();
        step();
        const double seconds = core::processor_seconds() - start;
        shortest = std::min(shortest, seconds);
        sum += seconds;
    }
    return shortest;
}

} // namespace

double StepCost::safe_time_step() const {
    return msm::default_safety_factor * critical_time_step;
}

int StepCost::steps_per_frame() const {
    return static_cast<int>(std::ceil(frame / safe_time_step()));
}

double critical_time_step(const core::Body &body, const msm::ElasticBody &springs) {
    const auto &positions = body.mesh.points;
    return 2.0 / msm::largest_angular_frequency(springs, positions, nothing_constrained(positions.size()));
}

StepCost step_cost(const core::Body &body, const msm::ElasticBody &springs) {
    const auto &positions = body.mesh.points;
    const auto conditions = nothing_constrained(positions.size());
    StepCost cost;
    cost.critical_time_step = critical_time_step(body, springs);
    auto steps = msm::FastSteps::prepare(springs, positions, conditions, {}, "symplectic_euler", cost.safe_time_step());
    cost.is_on_vector_units = steps.has_value();
    cost.seconds_per_step = steps ? shortest_time([&] { steps->take(1); })
                                  : shortest_time([&] { msm::elastic_gradient(springs, positions); });
    return cost;
}

double scaled_critical_time_step(const core::Body &body, const msm::ElasticBody &springs) {
    const auto conditions = nothing_constrained(body.mesh.points.size());
    const auto scaling = msm::scale_masses(body, springs, conditions);
    return 2.0 / msm::largest_angular_frequency(springs, body.mesh.points, conditions, scaling);
}

} // namespace livermark::studies
