#include "msm/integrator.hpp"

namespace livermark::msm::integrators {

namespace {

/// The trapezoidal rule with an explicit Euler step as its guess:
/// u_1 = u_0 + h/2 (v_0 + v*), v_1 = v_0 + h/2 (a(u_0, v_0) + a(u*, v*)), u* = u_0 + h v_0, v* = v_0 + h a(u_0, v_0)
Step prepare(const EquationOfMotion &equation, double h) {
    return [&equation, h, a = Eigen::VectorXd(), later = Eigen::VectorXd(), guess = State()](State &state) mutable {
        a.resize(state.displacement.size());
        later.resize(state.displacement.size());
        equation.acceleration(state.displacement, state.velocity, a);
        guess.displacement = state.displacement + h * state.velocity;
        guess.velocity = state.velocity + h * a;
        equation.acceleration(guess.displacement, guess.velocity, later);
        state.displacement += 0.5 * h * (state.velocity + guess.velocity);
        state.velocity += 0.5 * h * (a + later);
    };
}

} // namespace

Integrator heun() {
    return {.name = {},
            .summary = "Heun's method of order 2; without damping unstable at every step",
            .source = "Heun 1900, Z. Math. Phys. 45",
            .order = 2,
            .forces_per_step = 2,
            .prepare = prepare};
}

} // namespace livermark::msm::integrators
