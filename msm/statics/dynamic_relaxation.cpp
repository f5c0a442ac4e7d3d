#include "msm/statics/dynamic_relaxation.hpp"

#include <cmath>
#include <fmt/format.h>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"

namespace livermark::msm {

namespace {

constexpr int steps_between_checks = 25;

/// Forces that the loads leave unbalanced, and the elastic ones alone.
struct Forces {
    Eigen::VectorXd elastic;    ///< (3N) gradient of the energy [N]
    Eigen::VectorXd unbalanced; ///< (3N) elastic - load [N]
};

Forces forces_at(const Eigen::VectorXd &u, const ElasticBody &body, const std::vector<core::Vector3> &positions,
                 const Eigen::VectorXd &load) {
    auto moved = to_field(u);
    for (std::size_t i = 0; i < moved.size(); ++i)
        moved[i] += positions[i];
    Forces forces;
    forces.elastic = to_unknowns(elastic_gradient(body, moved));
    forces.unbalanced = forces.elastic - load;
    return forces;
}

} // namespace

Relaxation relax(const Integrator &integrator, const ElasticBody &body, const std::vector<core::Vector3> &positions,
                 const NodalConditions &conditions, const RelaxationOptions &options) {
    const auto load = to_unknowns(conditions.force);
    State state{to_unknowns(conditions.displacement), Eigen::VectorXd::Zero(load.size())};
    const Eigen::VectorXd is_free = state.displacement.array().isNaN().cast<double>();
    state.displacement = is_free.array().select(0.0, state.displacement);

    Relaxation result;
    auto &equilibrium = result.equilibrium;
    const double highest = largest_angular_frequency(body, positions, conditions);
    // Damping of the slowest modes by the mass hardly moves what the fastest can bear.
    result.time_step = default_safety_factor * critical_time_step(integrator, {}, 1e-3 * highest, highest);
    double omega = 0.0;
    equilibrium.status = core::SolutionStatus::not_converged;
    Forces forces;
    while (equilibrium.num_iterations < options.max_steps) {
        const auto equation = elastic_motion(body, positions, conditions, {2.0 * omega, 0.0});
        const auto step = integrator.prepare(equation, result.time_step);
        for (int s = 0; s < steps_between_checks; ++s)
            step(state);
        equilibrium.num_iterations += steps_between_checks;

        forces = forces_at(state.displacement, body, positions, load);
        const double residual = forces.unbalanced.cwiseProduct(is_free).norm();
        const double all = std::sqrt(forces.unbalanced.squaredNorm() + load.squaredNorm());
        if (!std::isfinite(residual)) {
            equilibrium.status = core::SolutionStatus::diverged;
            equilibrium.message = fmt::format("the motion was lost after {} steps of {:.3g} s",
                                              equilibrium.num_iterations, result.time_step);
            break;
        }
        if (residual <= options.tolerance * all) {
            equilibrium.status = core::SolutionStatus::ok;
            break;
        }
        const double stiffness = state.displacement.dot(forces.elastic);
        const double mass = state.displacement.dot(equation.mass.cwiseProduct(state.displacement));
        omega = mass > 0.0 ? std::sqrt(std::max(stiffness / mass, 0.0)) : 0.0;
    }
    if (equilibrium.status == core::SolutionStatus::not_converged)
        equilibrium.message = fmt::format("the body is not at rest after {} steps of {:.3g} s",
                                          equilibrium.num_iterations, result.time_step);
    equilibrium.displacement = to_field(state.displacement);
    equilibrium.constraint_force =
        to_field(forces.unbalanced.cwiseProduct(Eigen::VectorXd::Ones(is_free.size()) - is_free));
    return result;
}

} // namespace livermark::msm
