#include "models/mass_spring_model.hpp"

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "core/input_error.hpp"
#include "msm/dynamic_relaxation.hpp"
#include "msm/equilibrium.hpp"
#include "msm/explicit_steps.hpp"
#include "msm/release.hpp"
#include "msm/spectrum.hpp"

namespace livermark::models {

namespace {

using Clock = std::chrono::steady_clock;

double seconds(Clock::duration duration) {
    return std::chrono::duration<double>(duration).count();
}

/// |u - u_lin| / |u|, NaN where nobody asked for the linear answer
double nonlinearity(const msm::Equilibrium &equilibrium) {
    if (equilibrium.linear_displacement.empty())
        return std::numeric_limits<double>::quiet_NaN();
    double difference = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < equilibrium.displacement.size(); ++i) {
        difference += (equilibrium.displacement[i] - equilibrium.linear_displacement[i]).squaredNorm();
        size += equilibrium.displacement[i].squaredNorm();
    }
    return std::sqrt(difference / size);
}

msm::StepPlan plan_release(const core::Problem &problem, const msm::ElasticBody &body,
                           const msm::TimeStepping &choice) {
    return msm::plan_steps(problem, body, msm::nodal_conditions(problem, body.node_mass), choice);
}

/// Lets the tractions go where the static solution has come to.
void add_motion(core::Solution &solution, const core::Problem &problem, const msm::ElasticBody &body,
                const msm::TimeStepping &choice) {
    const auto start = Clock::now();
    const auto plan = plan_release(problem, body, choice);
    const auto conditions =
        msm::nodal_conditions({problem.body, core::without_tractions(problem.load_case)}, body.node_mass);
    const double planning_seconds = seconds(Clock::now() - start);
    solution.history = msm::release(problem, body, conditions, solution.displacement, plan);
    solution.history->setup_seconds += planning_seconds;
    if (!std::isnan(solution.history->diverged_at)) {
        solution.status = core::SolutionStatus::diverged;
        solution.message = fmt::format("the motion left all bounds at t = {:.3g} s with steps of {:.3g} s; {:.3g} s is "
                                       "the longest that is stable",
                                       solution.history->diverged_at, plan.time_step, plan.critical_time_step);
    }
}

/// An equilibrium, and in words how it was found.
std::pair<msm::Equilibrium, std::string> come_to_rest(const msm::ElasticBody &body,
                                                      const std::vector<core::Vector3> &points,
                                                      const msm::NodalConditions &conditions,
                                                      const ModelOptions &options) {
    if (options.equilibrium == EquilibriumMethod::newton) {
        auto found = msm::find_equilibrium(body, points, conditions);
        return {std::move(found), fmt::format("Newton, {} iterations, CHOLMOD", found.num_iterations)};
    }
    const auto &integrator = msm::find_integrator(options.time_stepping.integrator);
    auto found = msm::relax(integrator, body, points, conditions);
    return {std::move(found.equilibrium),
            fmt::format("dynamic relaxation, {} steps of {:.3g} s, {}", found.equilibrium.num_iterations,
                        found.time_step, integrator.name)};
}

core::Solution solve(const core::Problem &problem, const MakeMassSprings &make, const ModelOptions &options) {
    const auto start = Clock::now();
    auto [springs, body] = make(*problem.body);
    const auto ready = Clock::now();
    const auto &points = problem.body->mesh.points;
    const auto conditions = msm::nodal_conditions(problem, body.node_mass);
    auto [equilibrium, how] = come_to_rest(body, points, conditions, options);

    core::Solution solution;
    solution.solver = std::move(how);
    solution.status = equilibrium.status;
    solution.message = equilibrium.message;
    solution.reaction = msm::constraint_forces(problem, conditions, equilibrium.constraint_force);
    solution.nonlinearity = nonlinearity(equilibrium);
    solution.degrees_of_freedom = static_cast<std::int64_t>(3 * points.size());
    solution.setup_seconds = seconds(ready - start);
    solution.solve_seconds = seconds(Clock::now() - ready);
    auto positions = points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += equilibrium.displacement[i];
    solution.strain_energy = msm::elastic_energy(body, positions);
    solution.displacement = std::move(equilibrium.displacement);
    solution.springs = std::move(springs);
    solution.explicit_steps = msm::explicit_steps(body, points, conditions);
    if (problem.load_case.release && solution.status == core::SolutionStatus::ok)
        add_motion(solution, problem, body, options.time_stepping);
    return solution;
}

core::Modes modes(const core::Problem &problem, const MakeMassSprings &make, int count) {
    const auto start = Clock::now();
    const auto body = make(*problem.body).body;
    auto found =
        msm::lowest_modes(body, problem.body->mesh.points, msm::nodal_conditions(problem, body.node_mass), count);
    found.seconds = seconds(Clock::now() - start);
    return found;
}

void check(const core::Problem &problem, const MakeMassSprings &make, const ModelOptions &options) {
    const auto &integrator = msm::find_integrator(options.time_stepping.integrator);
    if (options.equilibrium == EquilibriumMethod::relaxation && !integrator.is_explicit)
        throw core::InputError(fmt::format("--equilibrium relaxation takes an explicit integrator, not {}; choose "
                                           "another --integrator",
                                           integrator.name));
    if (problem.load_case.release)
        plan_release(problem, make(*problem.body).body, options.time_stepping);
}

} // namespace

core::Model mass_spring_model(std::string name, std::string summary, std::string source, const MakeMassSprings &make,
                              const ModelOptions &options) {
    return {
        .name = std::move(name),
        .summary = std::move(summary),
        .source = std::move(source),
        .solve = [=](const core::Problem &problem) { return solve(problem, make, options); },
        .modes = [=](const core::Problem &problem, int count) { return modes(problem, make, count); },
        .check = [=](const core::Problem &problem) { check(problem, make, options); },
    };
}

} // namespace livermark::models
