#include "studies/stability/stability.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

#include "core/rayleigh_damping.hpp"
#include "msm/dynamics/highest_frequency.hpp"
#include "msm/dynamics/observed_time_step.hpp"
#include "msm/dynamics/spectrum.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/spring_network.hpp"
#include "results/provenance.hpp"
#include "studies/msm_choice.hpp"
#include "studies/run/output_folder.hpp"
#include "studies/run/problems.hpp"

namespace livermark::studies {

namespace {

/// A run that is this much above the limit has to be found out...
constexpr double found_out = 0.01;
/// ...by the growth of a mode that had no more than this part in the push, and in no more steps than this.
constexpr double part_of_push = 1e-3;
constexpr double most_steps = 30000.0;

/// The same ratio at two frequencies [Hz].
core::RayleighDamping damping_at(double ratio, const std::array<double, 2> &frequencies) {
    constexpr double radians = 2.0 * std::numbers::pi;
    return core::rayleigh_damping(ratio, radians * frequencies[0], radians * frequencies[1]);
}

/// Time that a longitudinal wave in a bar takes along a mean edge of the springs, in the material of the first region.
double element_time_step(const core::Body &body, const core::SpringNetwork &springs) {
    double sum = 0.0;
    for (const double length : springs.rest_length)
        sum += length;
    const auto &material = body.materials.front();
    return sum / static_cast<double>(springs.rest_length.size()) * std::sqrt(material.density / material.young_modulus);
}

results::Stability examine(const core::Problem &problem, const msm::SpringLaw &law,
                           const std::vector<msm::Integrator> &integrators, const StabilityOptions &options,
                           Steps &steps) {
    const auto &positions = problem.body->mesh.points;
    const auto springs = msm::spring_network(*problem.body, law);
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    results::Stability stability{.provenance = {},
                                 .body = problem.body->name,
                                 .spring_law = law.name,
                                 .load_case = problem.load_case.name,
                                 .damping = damping_at(options.damping_ratio, options.damping_frequencies),
                                 .limits = {}};
    steps.next(fmt::format("{} / frequencies", problem.body->name));
    stability.lowest_frequency = msm::lowest_modes(springs, positions, conditions, 1).angular_frequency.front();
    stability.largest_frequency = msm::largest_angular_frequency(springs, positions, conditions);
    stability.largest_frequency_bound = msm::gershgorin_angular_frequency(springs, positions, conditions);
    stability.element_time_step = element_time_step(*problem.body, springs);

    const auto observe = [&](const msm::Integrator &integrator, const core::RayleighDamping &damping,
                             double predicted) {
        msm::ObservationOptions run;
        const double growth = msm::largest_amplification(integrator, damping, stability.lowest_frequency,
                                                         stability.largest_frequency, (1.0 + found_out) * predicted);
        const double num_steps = std::log(run.growth / part_of_push) / std::log(growth);
        if (!(num_steps < most_steps))
            return std::numeric_limits<double>::quiet_NaN();
        run.num_steps = static_cast<int>(num_steps);
        return msm::observed_time_step(integrator, springs, positions, conditions, damping, predicted, run);
    };
    const auto find_limit = [&](const msm::Integrator &integrator, const core::RayleighDamping &damping) {
        results::StepLimit limit;
        limit.predicted =
            msm::critical_time_step(integrator, damping, stability.lowest_frequency, stability.largest_frequency);
        if (limit.has_number() && !options.no_observed)
            limit.observed = observe(integrator, damping, limit.predicted);
        return limit;
    };
    for (const auto &integrator : integrators) {
        steps.next(fmt::format("{} / {}", problem.body->name, integrator.name));
        stability.limits.push_back(
            {integrator.name, find_limit(integrator, {}), find_limit(integrator, stability.damping)});
    }
    return stability;
}

} // namespace

bool is_as_predicted(const results::Stability &stability) {
    const auto holds = [](const results::StepLimit &limit) {
        return std::isnan(limit.observed) || std::abs(limit.difference()) <= largest_difference;
    };
    return std::ranges::all_of(stability.limits, [&](const results::IntegratorLimits &limits) {
        return holds(limits.undamped) && holds(limits.damped);
    });
}

StabilityResults find_stability(const StabilityOptions &options, const std::string &command_line,
                                const ProgressReport &report) {
    const auto law = find_spring_law(options.law);
    const auto integrators = find_integrators(options.integrators);
    const auto [problems, notes, left_out] = read_scaled_problems(options.bodies, options.load_case, options.material);
    StabilityResults found{{}, notes};
    Steps steps(static_cast<int>(problems.size() * (1 + integrators.size())), report);
    for (const auto &problem : problems) {
        const auto folder = make_output_folder(options.output, problem);
        auto stability = examine(problem, law, integrators, options, steps);
        stability.provenance = results::current_provenance(command_line);
        results::write_stability(folder / fmt::format("stability.{}.h5", law.name), stability);
        found.of_body.push_back(std::move(stability));
    }
    return found;
}

} // namespace livermark::studies
