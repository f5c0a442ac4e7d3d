#include "msm/dynamics/stepper.hpp"

#include <memory>

#include "msm/dynamics/elastic_motion.hpp"
#include "msm/kernels/fast_steps.hpp"

namespace livermark::msm {

const char *to_string(StepKernel kernel) {
    switch (kernel) {
    case StepKernel::scalar:
        return "scalar";
    case StepKernel::simd_double:
        return "simd_double";
    case StepKernel::simd_float:
        return "simd_float";
    }
    return "";
}

Stepper make_stepper(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                     const NodalConditions &conditions, const core::RayleighDamping &damping,
                     const Integrator &integrator, double time_step, StepKernel wanted) {
    if (wanted != StepKernel::scalar) {
        const auto precision =
            wanted == StepKernel::simd_float ? ForcePrecision::single_precision : ForcePrecision::double_precision;
        if (auto fast = FastSteps::prepare(
                body, positions, conditions, damping, integrator.name, time_step,
                {.precision = precision, .num_threads = 1, .num_stages = integrator.forces_per_step}))
            return {wanted, [steps = *fast](State &state, int num_steps) mutable {
                        steps.set_state(state);
                        steps.take(num_steps);
                        state = steps.state();
                    }};
    }
    const auto equation = std::make_shared<EquationOfMotion>(elastic_motion(body, positions, conditions, damping));
    return {StepKernel::scalar,
            [equation, step = integrator.prepare(*equation, time_step)](State &state, int num_steps) {
                for (int s = 0; s < num_steps; ++s)
                    step(state);
            }};
}

} // namespace livermark::msm
