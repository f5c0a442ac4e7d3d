#include "msm/integrator.hpp"

namespace livermark::msm::integrators {

namespace {

/// u_1 = u_0 + h v_0 + h^2/2 a_0, v_1 = v_0 + h/2 (a_0 + a(u_1, v*)), where damping sees the guess v* = v_0 + h a_0,
/// which keeps the second order.
Step prepare(const EquationOfMotion &equation, double h) {
    return [&equation, h, a = Eigen::VectorXd(), later = Eigen::VectorXd(),
            guess = Eigen::VectorXd()](State &state) mutable {
        a.resize(state.displacement.size());
        later.resize(state.displacement.size());
        equation.acceleration(state.displacement, state.velocity, a);
        state.displacement += h * (state.velocity + 0.5 * h * a);
        guess = state.velocity + h * a;
        equation.acceleration(state.displacement, guess, later);
        state.velocity += 0.5 * h * (a + later);
    };
}

} // namespace

Integrator velocity_verlet() {
    return {.name = {},
            .summary = "velocity Verlet, order 2, energy bounded",
            .source = "Swope, Andersen, Berens, Wilson 1982, J. Chem. Phys. 76(1)",
            .order = 2,
            .is_symplectic = true,
            .forces_per_step = 2,
            .prepare = prepare};
}

} // namespace livermark::msm::integrators
