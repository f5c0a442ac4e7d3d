#include "studies/stability/scaled_steps.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>

#include "core/processor_time.hpp"
#include "models/motion/moving_method.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/dynamics/spectrum.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/nodal_conditions.hpp"
#include "studies/run/problems.hpp"

namespace livermark::studies {

namespace {

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

/// Of all tetrahedra, those with a node among these.
double part_of_tetrahedra(const core::TetraMesh &mesh, const std::vector<bool> &are_chosen) {
    const auto count = std::ranges::count_if(mesh.tetrahedra, [&](const auto &nodes) {
        return std::ranges::any_of(nodes, [&](int node) { return are_chosen[node]; });
    });
    return static_cast<double>(count) / static_cast<double>(mesh.tetrahedra.size());
}

void measure(ScaledSteps &steps, const msm::ElasticBody &springs, const core::Problem &problem,
             const msm::NodalConditions &conditions, const msm::MassScaling &scaling) {
    const auto prepare = [&](double critical, const msm::MassScaling &of_masses) {
        return msm::FastSteps::prepare(springs, problem.body->mesh.points, conditions, {}, "symplectic_euler",
                                       msm::default_safety_factor * critical, {.scaling = of_masses})
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
    const auto springs = model.make(*problem.body);
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    ScaledSteps steps{.body = problem.body->name, .model = model.name};
    const auto highest = [&](const msm::NodalConditions &constrained, const msm::MassScaling &scaling) {
        return msm::largest_angular_frequency(springs, mesh.points, constrained, scaling);
    };
    const auto scaling = msm::scale_masses(*problem.body, springs, conditions);
    std::vector<bool> are_stiff(mesh.points.size(), false);
    auto of_rest = conditions;
    for (const auto &part : scaling.parts) {
        steps.num_scaled_nodes += part.nodes.size();
        steps.largest_factor = std::max(steps.largest_factor, part.factor);
        for (const int node : part.nodes) {
            are_stiff[node] = true;
            of_rest.displacement[node].setZero();
        }
    }
    const double plain = highest(conditions, {}), rest = scaling.parts.empty() ? plain : highest(of_rest, {});
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

} // namespace

double ScaledSteps::cost() const {
    return seconds_per_step / (msm::default_safety_factor * critical_time_step);
}

double ScaledSteps::scaled_cost() const {
    return scaled_seconds_per_step / (msm::default_safety_factor * scaled_critical_time_step);
}

std::vector<ScaledSteps> find_scaled_steps(const StabilityOptions &options, const ProgressReport &report) {
    const auto set = read_constrained_problems(options.bodies, options.load_case, options.material);
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
