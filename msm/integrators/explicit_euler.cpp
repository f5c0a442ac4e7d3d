#include "msm/integrator.hpp"

namespace livermark::msm::integrators {

namespace {

/// u_1 = u_0 + h v_0, v_1 = v_0 + h a(u_0, v_0)
Step prepare(const EquationOfMotion &equation, double h) {
    return [&equation, h, a = Eigen::VectorXd()](State &state) mutable {
        a.resize(state.displacement.size());
        equation.acceleration(state.displacement, state.velocity, a);
        state.displacement += h * state.velocity;
        state.velocity += h * a;
    };
}

} // namespace

Integrator explicit_euler() {
    return {.name = {},
            .summary = "explicit Euler; without damping unstable at every step",
            .source = "Euler 1768, Institutionum calculi integralis I, 650",
            .prepare = prepare};
}

} // namespace livermark::msm::integrators
