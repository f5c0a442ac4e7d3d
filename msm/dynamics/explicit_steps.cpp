#include "msm/dynamics/explicit_steps.hpp"

#include <algorithm>
#include <chrono>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"

namespace livermark::msm {

namespace {

/// The other core may be busy with the same memory: the shortest of these is close to what an idle machine takes.
constexpr int num_timed_steps = 40;
constexpr auto integrator_name = "symplectic_euler";

double critical(double highest) {
    return critical_time_step(find_integrator(integrator_name), {}, highest, highest);
}

} // namespace

core::ExplicitSteps explicit_steps(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                   const NodalConditions &conditions, double highest) {
    using Clock = std::chrono::steady_clock;
    const auto &integrator = find_integrator(integrator_name);
    core::ExplicitSteps steps;
    if (!(highest > 0.0))
        return steps; // nothing can move: every step is stable
    steps.critical_time_step = critical(highest);
    const double time_step = default_safety_factor * steps.critical_time_step;
    const auto measure = [&](const std::function<void()> &take_step) {
        take_step(); // brings everything into the caches
        for (int s = 0; s < num_timed_steps; ++s) {
            const auto start = Clock::now();
            take_step();
            const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
            steps.seconds_per_step = s == 0 ? seconds : std::min(steps.seconds_per_step, seconds);
        }
    };
    if (auto fast = FastSteps::prepare(body, positions, conditions, {}, integrator.name, time_step)) {
        steps.kernel = to_string(StepKernel::simd_float);
        measure([&] { fast->take(1); });
    } else {
        steps.kernel = to_string(StepKernel::scalar);
        const auto stepper = make_stepper(body, positions, conditions, {}, integrator, time_step, StepKernel::scalar);
        const auto size = static_cast<Eigen::Index>(3 * positions.size());
        State state{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
        measure([&] { stepper.take(state, 1); });
    }
    return steps;
}

core::ExplicitSteps constrained_otherwise(core::ExplicitSteps steps, double highest) {
    if (!(highest > 0.0))
        return {};
    steps.critical_time_step = critical(highest);
    return steps;
}

} // namespace livermark::msm
