#include "msm/dynamics/histories.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm {

const std::vector<Integrator> &known_integrators() {
    static const auto all = [] {
        const auto explicit_ones = all_integrators(), implicit_ones = all_implicit_integrators();
        std::vector<Integrator> both(explicit_ones.begin(), explicit_ones.end());
        both.insert(both.end(), implicit_ones.begin(), implicit_ones.end());
        std::ranges::sort(both, {}, &Integrator::name);
        return both;
    }();
    return all;
}

namespace {

/// A motion further than this many times the size of the body has diverged.
constexpr double largest_motion = 10.0;
/// Nothing adds energy after the release: more than this many times what there was has come from the steps.
constexpr double largest_energy = 10.0;

/// The more accurate first: it is taken where both need as many forces.
constexpr std::array default_integrators{"runge_kutta_4", "runge_kutta_chebyshev"};
/// Least number of steps of a stabilised method, whose stable steps may be as long as the interval between two records.
constexpr int min_stabilised_steps = 3;
/// Forces in a step that are tried: with fewer steps get too short, with more a step is as long as the interval.
constexpr std::array forces_in_a_step{5, 6, 7, 8, 9, 10, 11, 12};

bool is_allowed(const TimeStepping &choice, double critical_time_step) {
    if (choice.time_step)
        return choice.force || *choice.time_step <= critical_time_step;
    return critical_time_step > 0.0;
}

[[noreturn]] void refuse(const TimeStepping &choice, const StepPlan &plan, const core::Problem &problem) {
    const auto &name = plan.integrator.name;
    if (!(plan.critical_time_step > 0.0))
        throw support::InputError(
            fmt::format("{} is unstable at every time step without damping; damp load case {}, or "
                        "take another integrator",
                        name, problem.load_case.name));
    throw support::InputError(fmt::format(
        "a time step of {:.3g} s is too long for {} on {}: {:.3g} s is the longest that is stable, and {:.3g} s is "
        "safe; take that, or force the step to see what happens",
        *choice.time_step, name, problem.body->name, plan.critical_time_step,
        default_safety_factor * plan.critical_time_step));
}

/// @param plan  with integrator and critical time step
void divide(StepPlan &plan, const TimeStepping &choice, double interval) {
    const double longest = choice.time_step.value_or(default_safety_factor * plan.critical_time_step);
    const int fewest = plan.integrator.is_stabilised && !choice.time_step ? min_stabilised_steps : 1;
    // Rounding must not make three steps of two.
    plan.steps_per_record = std::max(fewest, static_cast<int>(std::ceil(interval / longest - 1e-9)));
    plan.time_step = interval / plan.steps_per_record;
}

int forces_per_record(const StepPlan &plan) {
    return plan.steps_per_record * plan.integrator.forces_per_step;
}

/// The variant of a method whose stable steps get longer with the forces in them that is to need the fewest forces
/// between two records.
/// @param plan  of another number
Integrator with_best_number(const StepPlan &plan, const TimeStepping &choice, double interval) {
    const auto reach = [](int number) { return number * number - 1.0; };
    auto best = plan.integrator;
    int fewest = std::numeric_limits<int>::max();
    for (const int number : forces_in_a_step) {
        StepPlan other{.integrator = plan.integrator.with_forces_per_step(number)};
        other.critical_time_step = plan.critical_time_step * reach(number) / reach(plan.integrator.forces_per_step);
        divide(other, choice, interval);
        if (forces_per_record(other) < fewest) {
            fewest = forces_per_record(other);
            best = other.integrator;
        }
    }
    return best;
}

/// Number of steps from a state until something holds, if it ever does.
int steps_until(State state, const Stepper &stepper, const std::function<bool(const State &)> &holds) {
    int num_steps = 0;
    for (; !holds(state); ++num_steps)
        stepper.take(state, 1);
    return num_steps;
}

/// A body that relaxes where its slow history has ended; nothing of an elastic one.
std::optional<RelaxingBody> at_end_of(const core::Problem &problem, const ElasticBody &body,
                                      std::span<const core::PathPoint> path) {
    if (!problem.load_case.slow_history)
        return std::nullopt;
    const auto &[relaxation, times, factors, last_cycle] = *problem.load_case.slow_history;
    RelaxingBody relaxing(body, relaxation);
    for (std::size_t k = 1; k < path.size(); ++k) {
        auto positions = problem.body->mesh.points;
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += path[k].displacement[i].cast<double>();
        relaxing.go_on(to_unknowns(positions), times[k] - times[k - 1]);
    }
    return relaxing;
}

} // namespace

StepPlan plan_steps(const core::Problem &problem, double highest, const TimeStepping &choice) {
    const auto &release = problem.load_case.release.value();
    std::vector<std::string> names{default_integrators.begin(), default_integrators.end()};
    if (choice.integrator)
        names = {*choice.integrator};
    std::optional<StepPlan> best, refused;
    for (const auto &name : names) {
        StepPlan plan{.integrator = find_integrator(name, known_integrators()), .kernel = choice.kernel};
        const auto find_critical_time_step = [&] {
            plan.critical_time_step =
                critical_time_step(plan.integrator, release.damping, lowest_damped_part * highest, highest);
        };
        find_critical_time_step();
        if (plan.integrator.with_forces_per_step && !choice.time_step && plan.critical_time_step > 0.0) {
            auto other = with_best_number(plan, choice, release.output_interval);
            if (other.forces_per_step != plan.integrator.forces_per_step) {
                plan.integrator = std::move(other);
                find_critical_time_step();
            }
        }
        if (!is_allowed(choice, plan.critical_time_step)) {
            if (!refused || plan.critical_time_step > refused->critical_time_step)
                refused = plan;
            continue;
        }
        divide(plan, choice, release.output_interval);
        if (!best || forces_per_record(plan) < forces_per_record(*best))
            best = plan;
    }
    if (!best)
        refuse(choice, *refused, problem);
    return *best;
}

core::History release(const core::Problem &problem, const ElasticBody &body, const NodalConditions &conditions,
                      const Field &displacement, const StepPlan &plan, std::span<const core::PathPoint> path) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto start = core::Clock::now();
    const auto &points = problem.body->mesh.points;
    const auto &wanted = problem.load_case.release.value();
    const auto equation = elastic_motion(body, points, conditions, wanted.damping);
    const auto stepper =
        problem.load_case.slow_history
            ? make_relaxing_stepper(body, problem, conditions, wanted.damping, plan.integrator, plan.time_step,
                                    plan.kernel, path)
            : make_stepper(body, points, conditions, wanted.damping, plan.integrator, plan.time_step, plan.kernel);
    auto relaxing = at_end_of(problem, body, path);
    const double bound = largest_motion * core::extent(points);
    State state{to_unknowns(displacement), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * points.size()))};

    const auto is_within = [bound](const State &at) { return at.displacement.lpNorm<Eigen::Infinity>() < bound; };

    core::History history;
    history.integrator = plan.integrator.name;
    history.forces_per_step = plan.integrator.forces_per_step;
    history.kernel = to_string(stepper.kernel);
    history.time_step = plan.time_step;
    history.critical_time_step = plan.critical_time_step;
    const auto record = [&](int interval) {
        history.time.push_back(interval * wanted.output_interval);
        const bool is_lost = !std::isnan(history.diverged_at);
        for (const auto &probe : wanted.probes)
            history.displacement.emplace_back(
                is_lost ? core::Vector3::Constant(nan)
                        : core::Vector3(state.displacement.segment<3>(3 * static_cast<Eigen::Index>(probe.node))));
        const auto now = to_field(state.displacement);
        if (wanted.is_frame(interval))
            for (const auto &node : now)
                history.frames.emplace_back(is_lost ? Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN())
                                                    : Eigen::Vector3f(node.cast<float>()));
        const auto positions = moved(points, now);
        history.kinetic_energy.push_back(is_lost ? nan : kinetic_energy(equation, state));
        if (is_lost || !relaxing) {
            history.strain_energy.push_back(is_lost ? nan : elastic_energy(body, positions));
            return;
        }
        const auto x = to_unknowns(positions);
        if (interval > 0)
            relaxing->go_on(x, wanted.output_interval);
        history.strain_energy.push_back(relaxing->stored_energy(x));
    };
    record(0);
    const auto load = to_unknowns(conditions.force);
    const double energy = history.strain_energy[0] + std::abs(load.dot(state.displacement));
    history.setup_seconds = core::seconds_since(start);
    const auto ready = core::Clock::now();
    for (int interval = 1; interval <= wanted.num_steps; ++interval) {
        if (std::isnan(history.diverged_at)) {
            const auto before = state;
            stepper.take(state, plan.steps_per_record);
            if (!is_within(state)) {
                const int last = steps_until(before, stepper, [&](const State &at) { return !is_within(at); });
                history.diverged_at = (interval - 1) * wanted.output_interval + last * plan.time_step;
            }
        }
        if (std::isnan(history.diverged_at) && kinetic_energy(equation, state) > largest_energy * energy)
            history.diverged_at = interval * wanted.output_interval;
        record(interval);
    }
    history.solve_seconds = core::seconds_since(ready);
    return history;
}

namespace {

constexpr int steps_between_checks = 25;
constexpr double relaxation_tolerance = 1e-9;

} // namespace

Relaxation relax(const Integrator &integrator, const ElasticBody &body, const Field &positions,
                 const NodalConditions &conditions, int max_steps) {
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
    Eigen::VectorXd elastic, unbalanced; // forces (3N), the gradient of the energy and that less the load [N]
    while (equilibrium.num_iterations < max_steps) {
        const auto equation = elastic_motion(body, positions, conditions, {2.0 * omega, 0.0});
        const auto step = integrator.prepare(equation, result.time_step);
        for (int s = 0; s < steps_between_checks; ++s)
            step(state);
        equilibrium.num_iterations += steps_between_checks;

        elastic = to_unknowns(elastic_gradient(body, moved(positions, to_field(state.displacement))));
        unbalanced = elastic - load;
        const double residual = unbalanced.cwiseProduct(is_free).norm();
        const double all = std::sqrt(unbalanced.squaredNorm() + load.squaredNorm());
        if (!std::isfinite(residual)) {
            equilibrium.status = core::SolutionStatus::diverged;
            equilibrium.message = fmt::format("the motion was lost after {} steps of {:.3g} s",
                                              equilibrium.num_iterations, result.time_step);
            break;
        }
        if (residual <= relaxation_tolerance * all) {
            equilibrium.status = core::SolutionStatus::ok;
            break;
        }
        const double stiffness = state.displacement.dot(elastic);
        const double mass = state.displacement.dot(equation.mass.cwiseProduct(state.displacement));
        omega = mass > 0.0 ? std::sqrt(std::max(stiffness / mass, 0.0)) : 0.0;
    }
    if (equilibrium.status == core::SolutionStatus::not_converged)
        equilibrium.message = fmt::format("the body is not at rest after {} steps of {:.3g} s",
                                          equilibrium.num_iterations, result.time_step);
    equilibrium.displacement = to_field(state.displacement);
    equilibrium.constraint_force = to_field(unbalanced.cwiseProduct(Eigen::VectorXd::Ones(is_free.size()) - is_free));
    return result;
}

} // namespace livermark::msm
