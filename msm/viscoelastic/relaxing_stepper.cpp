#include "msm/viscoelastic/relaxing_stepper.hpp"

#include <memory>

#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/relaxation/relaxation_clock.hpp"
#include "msm/viscoelastic/held_steps.hpp"

namespace livermark::msm {

namespace {

/// Of the time between two records. In each the body is taken to stay in the middle of its way.
constexpr int parts_of_a_record = 8;

Eigen::VectorXd displacement_of(const core::PathPoint &point) {
    Eigen::VectorXd displacement(3 * static_cast<Eigen::Index>(point.displacement.size()));
    for (std::size_t i = 0; i < point.displacement.size(); ++i)
        displacement.segment<3>(3 * static_cast<Eigen::Index>(i)) = point.displacement[i].cast<double>();
    return displacement;
}

/// @param stay  lets a body stay in a displacement for a time
template <class Stay>
void follow_records(const std::vector<double> &times, std::span<const core::PathPoint> history, const Stay &stay) {
    for (std::size_t k = 1; k < history.size(); ++k) {
        const auto before = displacement_of(history[k - 1]), after = displacement_of(history[k]);
        for (int part = 0; part < parts_of_a_record; ++part) {
            const double on_the_way = (part + 0.5) / parts_of_a_record;
            stay((1.0 - on_the_way) * before + on_the_way * after, (times[k] - times[k - 1]) / parts_of_a_record);
        }
    }
}

} // namespace

Stepper make_relaxing_stepper(const ElasticBody &body, const core::Problem &problem, const NodalConditions &conditions,
                              const core::RayleighDamping &damping, const Integrator &integrator, double time_step,
                              StepKernel wanted, std::span<const core::PathPoint> history) {
    const auto &positions = problem.body->mesh.points;
    const auto &[relaxation, times, factors, last_cycle] = problem.load_case.slow_history.value();
    FastStepOptions options{.num_threads = 1, .num_stages = integrator.forces_per_step, .relaxation = relaxation};
    if (wanted != StepKernel::scalar) {
        options.precision =
            wanted == StepKernel::simd_float ? ForcePrecision::single_precision : ForcePrecision::double_precision;
        if (auto fast = FastSteps::prepare(body, positions, conditions, damping, integrator.name, time_step, options)) {
            follow_records(times, history, [&](const Eigen::VectorXd &displacement, double time) {
                fast->set_state({displacement, Eigen::VectorXd::Zero(displacement.size())});
                fast->relax(time);
            });
            return {wanted, [steps = *fast](State &state, int num_steps) mutable {
                        steps.set_state(state);
                        steps.take(num_steps);
                        state = steps.state();
                    }};
        }
    }
    const int num_held = steps_between_turns(relaxation, options.relaxation_error, time_step);
    const auto slow =
        std::make_shared<HeldSteps>(body, relaxation, positions, conditions, damping, integrator, time_step, num_held);
    follow_records(times, history,
                   [&](const Eigen::VectorXd &displacement, double time) { slow->relax(displacement, time); });
    return {StepKernel::scalar, [slow](State &state, int num_steps) { slow->take(state, num_steps); }};
}

} // namespace livermark::msm
