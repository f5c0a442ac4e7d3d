#include "msm/integrator.hpp"

namespace livermark::msm {

std::vector<ChebyshevStage> chebyshev_stages(int num_stages, double epsilon) {
    const auto s = static_cast<std::size_t>(num_stages);
    const double w0 = 1.0 + epsilon / static_cast<double>(s * s);
    std::vector<double> value(s + 1), slope(s + 1), curvature(s + 1); // of the Chebyshev polynomials T_j at w_0
    value[0] = 1.0;
    value[1] = w0;
    slope[1] = 1.0;
    for (std::size_t j = 2; j <= s; ++j) {
        value[j] = 2.0 * w0 * value[j - 1] - value[j - 2];
        slope[j] = 2.0 * value[j - 1] + 2.0 * w0 * slope[j - 1] - slope[j - 2];
        curvature[j] = 4.0 * slope[j - 1] + 2.0 * w0 * curvature[j - 1] - curvature[j - 2];
    }
    const double w1 = slope[s] / curvature[s];
    std::vector<double> b(s + 1);
    for (std::size_t j = 2; j <= s; ++j)
        b[j] = curvature[j] / (slope[j] * slope[j]);
    b[0] = b[1] = b[2];

    std::vector<ChebyshevStage> stages{
        {.mu = 0.0, .nu = 0.0, .mu_tilde = b[1] * w1, .gamma_tilde = 0.0, .time = b[1] * w1}};
    double time_before = 0.0;
    for (std::size_t j = 2; j <= s; ++j) {
        const double a_before = 1.0 - b[j - 1] * value[j - 1];
        ChebyshevStage stage{.mu = 2.0 * b[j] * w0 / b[j - 1],
                             .nu = -b[j] / b[j - 2],
                             .mu_tilde = 2.0 * b[j] * w1 / b[j - 1],
                             .gamma_tilde = -a_before * 2.0 * b[j] * w1 / b[j - 1],
                             .time = 0.0};
        const double time = stages.back().time;
        stage.time = stage.mu * time + stage.nu * time_before + stage.mu_tilde + stage.gamma_tilde;
        time_before = time;
        stages.push_back(stage);
    }
    return stages;
}

std::vector<ChebyshevStage> chebyshev_stages(int num_stages) {
    constexpr double epsilon = 2.0 / 13.0; // with a larger one steps are shorter
    return chebyshev_stages(num_stages, epsilon);
}

namespace integrators {

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

} // namespace integrators

} // namespace livermark::msm
