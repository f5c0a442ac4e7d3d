#include <array>

#include "msm/integrator.hpp"

namespace livermark::msm::integrators {

namespace {

/// The classical method for (u, v)' = (v, a(u, v)).
Step prepare(const EquationOfMotion &equation, double h) {
    return [&equation, h, stage = State(), sum = State(), a = Eigen::VectorXd()](State &state) mutable {
        constexpr std::array weight{1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
        const std::array next{0.5 * h, 0.5 * h, h}; // where the stages after the first stand
        a.resize(state.displacement.size());
        stage = state;
        sum = state;
        for (std::size_t s = 0; s < weight.size(); ++s) {
            equation.acceleration(stage.displacement, stage.velocity, a);
            sum.displacement += weight[s] * h * stage.velocity;
            sum.velocity += weight[s] * h * a;
            if (s < next.size()) {
                stage.displacement = state.displacement + next[s] * stage.velocity;
                stage.velocity = state.velocity + next[s] * a;
            }
        }
        std::swap(state, sum);
    };
}

} // namespace

Integrator runge_kutta_4() {
    return {.name = {},
            .summary = "the classical Runge-Kutta method of order 4",
            .source = "Kutta 1901, Z. Math. Phys. 46",
            .order = 4,
            .forces_per_step = 4,
            .prepare = prepare};
}

} // namespace livermark::msm::integrators
