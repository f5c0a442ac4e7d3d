#include "studies/stability/stability.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <span>

#include "core/rayleigh_damping.hpp"
#include "models/mass_spring_model.hpp"
#include "models/model_table.hpp"
#include "msm/dynamics/spectrum.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/implicit_integrators.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/spring_network.hpp"
#include "results/provenance.hpp"
#include "studies/files.hpp"
#include "studies/run/problems.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

/// The integrators that were named, in that order; all if none was.
/// @throws support::InputError for a name that there is not, or that comes twice
std::vector<msm::Integrator> find_integrators(const std::vector<std::string> &names) {
    const std::span<const msm::Integrator> all = msm::known_integrators();
    std::vector<msm::Integrator> chosen;
    for (const auto &name : names) {
        if (std::ranges::find(chosen, name, &msm::Integrator::name) != chosen.end())
            throw support::InputError(fmt::format("integrator '{}' is asked for twice; name it once", name));
        chosen.push_back(support::find_named(all, name, "integrator"));
    }
    return names.empty() ? std::vector<msm::Integrator>(all.begin(), all.end()) : chosen;
}

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

/// Time that a longitudinal wave in a bar takes along a mean edge of the mesh, in the material of the first region.
double element_time_step(const core::Body &body) {
    const auto &points = body.mesh.points;
    const auto edges = core::edge_table(body.mesh.tetrahedra).edges;
    double sum = 0.0;
    for (const auto &[i, j] : edges)
        sum += (points[i] - points[j]).norm();
    const auto &material = body.materials.front();
    return sum / static_cast<double>(edges.size()) * std::sqrt(material.density / material.young_modulus);
}

/// Springs of a law or of a model.
struct NamedSprings {
    std::string law, model; ///< one of them is empty
    std::function<msm::ElasticBody(const std::shared_ptr<const core::Body> &)> make;
};

std::vector<NamedSprings> springs_to_examine(const StabilityOptions &options) {
    if (options.models.empty()) {
        const auto law = support::find_named(msm::all_spring_laws(), options.law, "spring law");
        return {{law.name, {}, [law](const std::shared_ptr<const core::Body> &body) {
                     return msm::ElasticBody(msm::spring_network(*body, law));
                 }}};
    }
    const auto known = models::all_models();
    std::vector<NamedSprings> chosen;
    for (const auto &name : options.models) {
        if (std::ranges::find(chosen, name, &NamedSprings::model) != chosen.end())
            throw support::InputError(fmt::format("model '{}' is asked for twice; name it once", name));
        const auto model = support::find_named(known, name, "model");
        chosen.push_back({{}, name, [model](const std::shared_ptr<const core::Body> &body) {
                              const auto springs = models::springs_of(model, body);
                              if (!springs)
                                  throw support::InputError(fmt::format(
                                      "model {} is not made of springs, and moves in implicit steps, which are stable "
                                      "at every length, or not at all; give a model of springs, such as nodal_springs",
                                      model.name));
                              return springs->body;
                          }});
    }
    return chosen;
}

results::Stability examine(const core::Problem &problem, const NamedSprings &named, const msm::ElasticBody &springs,
                           const std::vector<msm::Integrator> &integrators, const StabilityOptions &options,
                           Steps &steps) {
    const auto &positions = problem.body->mesh.points;
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    results::Stability stability{.provenance = {},
                                 .body = problem.body->name,
                                 .spring_law = named.law,
                                 .model = named.model,
                                 .load_case = problem.load_case.name,
                                 .damping = damping_at(options.damping_ratio, options.damping_frequencies),
                                 .limits = {}};
    steps.next(fmt::format("{} / {} / frequencies", problem.body->name, stability.springs()));
    stability.lowest_frequency = msm::lowest_modes(springs, positions, conditions, 1).angular_frequency.front();
    stability.largest_frequency = msm::largest_angular_frequency(springs, positions, conditions);
    stability.largest_frequency_bound = msm::gershgorin_angular_frequency(springs, positions, conditions);
    stability.element_time_step = element_time_step(*problem.body);

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
        steps.next(fmt::format("{} / {} / {}", problem.body->name, stability.springs(), integrator.name));
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
    const auto all_springs = springs_to_examine(options);
    const auto integrators = find_integrators(options.integrators);
    const auto [problems, notes, left_out] =
        read_constrained_problems(options.bodies, options.load_case, options.material);
    StabilityResults found{{}, notes};
    Steps steps(static_cast<int>(problems.size() * all_springs.size() * (1 + integrators.size())), report);
    for (const auto &problem : problems)
        for (const auto &named : all_springs) {
            const auto springs = named.make(problem.body); // which may refuse, before anything is written
            const OutputFile file(options.output, problem,
                                  fmt::format("stability.{}.h5", named.model.empty() ? named.law : named.model));
            auto stability = examine(problem, named, springs, integrators, options, steps);
            stability.provenance = results::current_provenance(command_line);
            results::write_stability(file.path(), stability);
            found.of_body.push_back(std::move(stability));
        }
    return found;
}

} // namespace livermark::studies
