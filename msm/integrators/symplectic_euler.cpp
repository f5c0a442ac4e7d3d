#include "msm/integrator.hpp"

namespace livermark::msm::integrators {

namespace {

/// v_1 = v_0 + h a(u_0, v_0), u_1 = u_0 + h v_1
Step prepare(const EquationOfMotion &equation, double h) {
    return [&equation, h, a = Eigen::VectorXd()](State &state) mutable {
        a.resize(state.displacement.size());
        equation.acceleration(state.displacement, state.velocity, a);
        state.velocity += h * a;
        state.displacement += h * state.velocity;
    };
}

} // namespace

Integrator symplectic_euler() {
    return {.name = {},
            .summary = "symplectic (semi-implicit) Euler: one force per step, energy bounded",
            .source = "Hairer, Lubich, Wanner 2006, Geometric Numerical Integration, I.1.2",
            .is_symplectic = true,
            .prepare = prepare};
}

} // namespace livermark::msm::integrators
