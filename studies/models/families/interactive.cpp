#include <cstdint>
#include <fmt/format.h>
#include <memory>
#include <utility>
#include <vector>

#include "core/stopwatch.hpp"
#include "interactive/equilibrium.hpp"
#include "interactive/method.hpp"
#include "msm/elastic_body.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::models::families {

namespace {

using livermark::interactive::Equilibrium;
using livermark::interactive::Field;
using livermark::interactive::Method;
using livermark::interactive::Scene;
using livermark::interactive::Simulation;

Field to_field(const std::vector<core::Vector3> &vectors) {
    Field field(3, vectors.size());
    for (std::size_t i = 0; i < vectors.size(); ++i)
        field.col(static_cast<Eigen::Index>(i)) = vectors[i];
    return field;
}

/// They constrain whole nodes, and know no pressure that follows the surface.
bool can_solve(const core::Problem &problem) {
    const auto &load_case = problem.load_case;
    for (int f = 0; f < problem.body->mesh.num_boundary_triangles(); ++f)
        if (load_case.follows_surface(f) || (load_case.is_constrained(f) && load_case.value[f].array().isNaN().any()))
            return false;
    return true;
}

/// A problem as interactive methods see it. Targets are of the constrained nodes.
struct NodalProblem {
    NodalProblem(const core::Problem &problem, std::vector<double> mass)
        : conditions(msm::nodal_conditions(problem, mass)),
          forces(to_field(conditions.force)), scene{.body = problem.body,
                                                    .node_mass = std::move(mass),
                                                    .constrained_nodes = {}} {
        const auto &points = problem.body->mesh.points;
        for (std::size_t i = 0; i < points.size(); ++i)
            if (!conditions.displacement[i].array().isNaN().any())
                scene.constrained_nodes.push_back(static_cast<int>(i));
        targets.resize(3, static_cast<Eigen::Index>(scene.constrained_nodes.size()));
        for (Eigen::Index c = 0; c < targets.cols(); ++c) {
            const int node = scene.constrained_nodes[c];
            targets.col(c) = points[node] + conditions.displacement[node];
        }
    }

    msm::NodalConditions conditions;
    Field forces, targets;
    Scene scene;
};

std::vector<core::Vector3> displacements(const core::Problem &problem, const Field &positions) {
    std::vector<core::Vector3> result = problem.body->mesh.points;
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = positions.col(static_cast<Eigen::Index>(i)) - result[i];
    return result;
}

std::vector<core::Vector3> reactions(const core::Problem &problem, const NodalProblem &nodal,
                                     const Simulation &simulation, const Equilibrium &state) {
    const Field pushed = livermark::interactive::reactions_to(
        simulation.scene(), state.elastic_forces + state.load * simulation.external_forces());
    std::vector<core::Vector3> force(problem.body->mesh.points.size(), core::Vector3::Zero());
    for (Eigen::Index c = 0; c < pushed.cols(); ++c)
        force[nodal.scene.constrained_nodes[c]] = pushed.col(c);
    return msm::constraint_forces(problem, nodal.conditions, force, state.load);
}

core::Solution solve(const core::Problem &problem, const Method &method) {
    const auto start = core::Clock::now();
    const NodalProblem nodal(problem, livermark::msm::lumped_masses(*problem.body));
    const auto simulation = method.prepare(nodal.scene);
    simulation->set_external_forces(nodal.forces);
    simulation->set_targets(nodal.targets);
    core::Solution solution;
    solution.setup_seconds = core::seconds_since(start);
    auto fractions = problem.load_case.path;
    if (fractions.empty())
        fractions = {1.0};
    constexpr double tolerance = 1e-9;
    const auto &foundation = problem.load_case.foundation;
    const auto states = livermark::interactive::equilibria(
        *simulation, fractions, tolerance, problem.load_case.press_depth, foundation ? &*foundation : nullptr);
    const auto &last = states.back();
    if (!last.converged) {
        solution.status = core::SolutionStatus::not_converged;
        solution.message = fmt::format("Newton's method found no equilibrium beyond {:.3g} of the load", last.fraction);
    }
    solution.displacement = displacements(problem, last.positions);
    solution.reaction = reactions(problem, nodal, *simulation, last);
    solution.strain_energy = simulation->energy().value(last.positions); // of the body, as of other models
    solution.degrees_of_freedom = static_cast<std::int64_t>(last.positions.size());
    solution.solver = fmt::format("Newton, {} iterations, CHOLMOD", last.iterations);
    for (const auto &state : states)
        if (state.converged && !problem.load_case.path.empty()) {
            auto &point = solution.path.emplace_back();
            for (const auto &displacement : displacements(problem, state.positions))
                point.displacement.push_back(displacement.cast<float>());
            point.reaction = reactions(problem, nodal, *simulation, state);
            point.strain_energy = simulation->energy().value(state.positions);
        }
    solution.solve_seconds = core::seconds_since(start) - solution.setup_seconds;
    return solution;
}

core::Model model(const Method &method) {
    return {.name = method.name,
            .summary = fmt::format("{}; the equilibrium that it converges to", method.summary),
            .source = method.source,
            .prepare = core::solves_each([method](const core::Problem &problem) { return solve(problem, method); }),
            .only_when_named = true,
            .follows = core::EventSet::of<core::Release, core::ToolMotion, core::Foundation>(),
            .is_wanted = can_solve};
}

} // namespace

/// The static solutions of interactive methods, with no limit to their iterations. They join a run only when they are
/// named.
ModelFamily interactive() {
    return {.name = {}, .models = [](const ModelOptions & /*options*/) {
                std::vector<core::Model> models;
                for (const auto &method : livermark::interactive::all_methods())
                    models.push_back(model(method));
                return models;
            }};
}

} // namespace livermark::models::families
