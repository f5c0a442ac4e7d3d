#include "studies/frequencies/frequencies.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <numbers>
#include <span>

#include "core/relaxation.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

/// The models that were named, in that order.
std::vector<core::Model> models_with_modes(const std::vector<std::string> &wanted) {
    auto able = models::all_models();
    std::erase_if(able, [](const core::Model &model) { return !model.modes; });
    std::vector<core::Model> chosen;
    for (const auto &name : wanted) {
        const auto &model = support::find_named(able, name, "model with modes");
        if (std::ranges::find(chosen, name, &core::Model::name) != chosen.end())
            throw support::InputError(fmt::format("model '{}' is asked for twice; name it once", name));
        chosen.push_back(model);
    }
    return chosen;
}

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

/// Other programs take turns on this core: the shortest of these is close to what an idle machine takes.
constexpr int num_timed_steps = 200;
/// Below this part of a rate a node does not ask for the next one.
constexpr double rounding_of_rate = 1e-6;

std::vector<bool> with_neighbours(const core::TetraMesh &mesh, const std::vector<bool> &are_chosen) {
    auto result = are_chosen;
    for (const auto &nodes : mesh.tetrahedra)
        if (std::ranges::any_of(nodes, [&](int node) { return are_chosen[node]; }))
            for (const int node : nodes)
                result[node] = true;
    return result;
}

/// Part of all tetrahedra that have a node among these.
double part_of_tetrahedra(const core::TetraMesh &mesh, const std::vector<bool> &are_chosen) {
    const auto count = std::ranges::count_if(mesh.tetrahedra, [&](const auto &nodes) {
        return std::ranges::any_of(nodes, [&](int node) { return are_chosen[node]; });
    });
    return static_cast<double>(count) / static_cast<double>(mesh.tetrahedra.size());
}

void measure(ScaledSteps &steps, const msm::ElasticBody &springs, const core::Problem &problem,
             const msm::NodalConditions &conditions, const msm::MassScaling &scaling) {
    const auto prepare = [&](double critical, const msm::MassScaling &mass_scaling) {
        return msm::FastSteps::prepare(msm::part_terms(springs).in_kernels, problem.body->mesh.points, conditions, {},
                                       "symplectic_euler", msm::default_safety_factor * critical,
                                       {.scaling = mass_scaling})
            .value();
    };
    auto plain = prepare(steps.critical_time_step, {}), scaled = prepare(steps.scaled_critical_time_step, scaling);
    const auto shorten = [](double &shortest, msm::FastSteps &of) {
        const double start = core::processor_seconds();
        of.take(1);
        shortest = std::min(shortest, core::processor_seconds() - start);
    };
    steps.seconds_per_step = steps.scaled_seconds_per_step = std::numeric_limits<double>::infinity();
    for (int s = 0; s < num_timed_steps; ++s) {
        shorten(steps.seconds_per_step, plain);
        shorten(steps.scaled_seconds_per_step, scaled);
    }
}

ScaledSteps examine_scaled(const core::Problem &problem, const models::MovingSpringModel &model) {
    const auto &mesh = problem.body->mesh;
    const auto springs = msm::with_vessel_lines(model.make(*problem.body), *problem.body);
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    ScaledSteps steps{.body = problem.body->name, .model = model.name};
    const auto highest = [&](const msm::NodalConditions &constrained, const msm::MassScaling &scaling) {
        return msm::largest_angular_frequency(springs, mesh.points, constrained, scaling);
    };
    const auto scaling = msm::scale_masses(*problem.body, springs, conditions);
    std::vector<bool> are_stiff(mesh.points.size(), false);
    auto rest_conditions = conditions;
    for (const auto &part : scaling.parts) {
        steps.num_scaled_nodes += part.nodes.size();
        steps.largest_factor = std::max(steps.largest_factor, part.factor);
        for (const int node : part.nodes) {
            are_stiff[node] = true;
            rest_conditions.displacement[node].setZero();
        }
    }
    const double plain = highest(conditions, {}), rest = scaling.parts.empty() ? plain : highest(rest_conditions, {});
    steps.critical_time_step = 2.0 / plain;
    steps.critical_time_step_of_rest = 2.0 / rest;
    steps.scaled_critical_time_step = scaling.parts.empty() ? 2.0 / plain : 2.0 / highest(conditions, scaling);

    const auto bounds = msm::nodal_frequency_bounds(springs, mesh.points, conditions);
    const double sharpness = plain / *std::ranges::max_element(bounds);
    for (const double bound : bounds) {
        const double rate = std::max(1.0, sharpness * bound / rest);
        const auto power = static_cast<std::size_t>(std::ceil(std::log2(rate) - rounding_of_rate));
        ++steps.nodes_of_rate[std::min(power, steps.nodes_of_rate.size() - 1)];
    }
    steps.tetrahedra_at_stiff_nodes = part_of_tetrahedra(mesh, are_stiff);
    steps.tetrahedra_with_a_ring = part_of_tetrahedra(mesh, with_neighbours(mesh, are_stiff));
    measure(steps, springs, problem, conditions, scaling);
    if (!scaling.parts.empty()) {
        const auto before = msm::lowest_modes(springs, mesh.points, conditions, num_compared_modes).angular_frequency;
        const auto after =
            msm::lowest_modes(springs, mesh.points, conditions, num_compared_modes, scaling).angular_frequency;
        steps.first_change = 1.0 - after.front() / before.front();
        for (std::size_t mode = 0; mode < before.size(); ++mode)
            steps.largest_change = std::max(steps.largest_change, 1.0 - after[mode] / before[mode]);
    }
    return steps;
}

/// Bodies with constraints alone: what bears them is none of the springs whose steps are looked at.
/// @throws support::InputError for a load case with a foundation
ProblemSet read_unborne_problems(const StabilityOptions &options) {
    auto set = read_constrained_problems(options.bodies, options.load_case, options.material);
    for (const auto &problem : set.problems)
        if (problem.load_case.foundation)
            throw support::InputError(fmt::format("load case {} has an elastic foundation, which explicit steps of "
                                                  "springs do not know; name another one, such as traction",
                                                  problem.load_case.name));
    return set;
}

} // namespace

Found<results::Result> find_modes(const ModesOptions &options, const std::string &command_line,
                                  const ProgressReport &report) {
    const auto models = models_with_modes(options.models);
    const auto [problems, notes, left_out] =
        read_constrained_problems(options.bodies, options.load_case, options.material);
    Found<results::Result> found{{}, notes};
    Steps steps(static_cast<int>(problems.size() * models.size()), report);
    for (const auto &problem : problems) {
        const OutputFile file(options.output, problem, fmt::format("modes.{}.h5", problem.load_case.name));
        results::Result result{
            .provenance = results::current_provenance(command_line), .problem = problem, .models = {}, .modes = {}};
        for (const auto &model : models) {
            steps.next(fmt::format("{} / {}", problem.body->name, model.name));
            result.modes.push_back({model.name, model.modes(problem, options.count)});
        }
        results::write_result(file.path(), result);
        found.records.push_back(std::move(result));
    }
    return found;
}

bool is_as_predicted(const results::Stability &stability) {
    const auto holds = [](const results::StepLimit &limit) {
        return std::isnan(limit.observed) || std::abs(limit.difference()) <= largest_difference;
    };
    return std::ranges::all_of(stability.limits, [&](const results::IntegratorLimits &limits) {
        return holds(limits.undamped) && holds(limits.damped);
    });
}

Found<results::Stability> find_stability(const StabilityOptions &options, const std::string &command_line,
                                         const ProgressReport &report) {
    const auto all_springs = springs_to_examine(options);
    const auto integrators = find_integrators(options.integrators);
    const auto [problems, notes, left_out] = read_unborne_problems(options);
    Found<results::Stability> found{{}, notes};
    Steps steps(static_cast<int>(problems.size() * all_springs.size() * (1 + integrators.size())), report);
    for (const auto &problem : problems)
        for (const auto &named : all_springs) {
            const auto springs = named.make(problem.body); // which may refuse, before anything is written
            const OutputFile file(options.output, problem,
                                  fmt::format("stability.{}.h5", named.model.empty() ? named.law : named.model));
            auto stability = examine(problem, named, springs, integrators, options, steps);
            stability.provenance = results::current_provenance(command_line);
            results::write_stability(file.path(), stability);
            found.records.push_back(std::move(stability));
        }
    return found;
}

double ScaledSteps::cost() const {
    return seconds_per_step / (msm::default_safety_factor * critical_time_step);
}

double ScaledSteps::scaled_cost() const {
    return scaled_seconds_per_step / (msm::default_safety_factor * scaled_critical_time_step);
}

std::vector<ScaledSteps> find_scaled_steps(const StabilityOptions &options, const ProgressReport &report) {
    const auto set = read_unborne_problems(options);
    std::vector<models::MovingSpringModel> models;
    std::ranges::copy_if(models::moving_spring_models(), std::back_inserter(models),
                         [](const auto &model) { return !model.only_when_named; });
    Steps progress(static_cast<int>(set.problems.size() * models.size()), report);
    std::vector<ScaledSteps> found;
    for (const auto &model : models)
        for (const auto &problem : set.problems) {
            progress.next(fmt::format("{} / {}", problem.body->name, model.name));
            found.push_back(examine_scaled(problem, model));
        }
    return found;
}

} // namespace livermark::studies
