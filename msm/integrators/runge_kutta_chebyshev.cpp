#include "msm/integrator.hpp"

namespace livermark::msm::integrators {

namespace {

/// For y = (u, v) and f(y) = (v, a(u, v)); see ChebyshevStage.
Step prepare(const EquationOfMotion &equation, double h, const std::vector<ChebyshevStage> &stages) {
    return [&equation, h, stages, at = State(), first = Eigen::VectorXd(), a = Eigen::VectorXd(), last = State(),
            before = State(), next = State()](State &state) mutable {
        const auto size = state.displacement.size();
        first.resize(size);
        a.resize(size);
        last = before = {Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
        at = state;
        for (const auto &stage : stages) {
            equation.acceleration(at.displacement, at.velocity, a);
            if (&stage == &stages.front())
                first = a;
            next.displacement = stage.mu * last.displacement + stage.nu * before.displacement +
                                h * (stage.mu_tilde * at.velocity + stage.gamma_tilde * state.velocity);
            next.velocity = stage.mu * last.velocity + stage.nu * before.velocity +
                            h * (stage.mu_tilde * a + stage.gamma_tilde * first);
            at.displacement = state.displacement + next.displacement;
            at.velocity = state.velocity + next.velocity;
            std::swap(before, last);
            std::swap(last, next);
        }
        std::swap(state, at);
    };
}

Integrator with_stages(int num_stages) {
    return {.name = "runge_kutta_chebyshev",
            .summary = "stabilised Runge-Kutta-Chebyshev method of order 2: long steps where stiffness damps, none "
                       "without damping",
            .source = "Sommeijer, Shampine, Verwer 1998, J. Comput. Appl. Math. 88",
            .order = 2,
            .is_stabilised = true,
            .forces_per_step = num_stages,
            .prepare =
                [stages = chebyshev_stages(num_stages)](const EquationOfMotion &equation, double h) {
                    return msm::integrators::prepare(equation, h, stages);
                },
            .with_forces_per_step = with_stages};
}

} // namespace

Integrator runge_kutta_chebyshev() {
    return with_stages(usual_num_stages);
}

} // namespace livermark::msm::integrators
