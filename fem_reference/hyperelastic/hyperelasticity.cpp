#include "fem_reference/hyperelastic/hyperelasticity.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>
#include <utility>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/hyperelastic/hyperelastic_motion.hpp"

namespace livermark::hyperelastic {

namespace {

using core::Vector3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void check(const LoadPath &path) {
    const auto &fractions = path.fractions;
    const bool ascends = std::ranges::adjacent_find(fractions, std::greater_equal<>()) == fractions.end();
    if (fractions.empty() || !ascends || !(fractions.front() > 0.0) || fractions.back() != 1.0)
        throw std::invalid_argument("the fractions of a load path have to ascend from above 0 to 1");
}

/// |u - v| / |u| with the norm of core::Comparison.
double relative_difference(const core::TetraMesh &mesh, const std::vector<Vector3> &u, const std::vector<Vector3> &v) {
    const auto volumes = core::nodal_volumes(mesh);
    double difference = 0.0, size = 0.0;
    for (std::size_t node = 0; node < u.size(); ++node) {
        difference += volumes[node] * (u[node] - v[node]).squaredNorm();
        size += volumes[node] * u[node].squaredNorm();
    }
    return std::sqrt(difference / size);
}

std::string description(const FollowedPath &path, bool has_pressure) {
    std::size_t corrections = 0, linear = 0, most = 0;
    for (const auto &step : path.steps) {
        corrections += step.linear_iterations.size();
        most = std::max(most, step.linear_iterations.size());
        for (const int iterations : step.linear_iterations)
            linear += static_cast<std::size_t>(iterations);
    }
    return fmt::format("Newton, {} load steps, {} linear solves, {} in a step at most; GMRES, {} iterations, {} {}",
                       path.steps.size(), corrections, most, linear, path.factorisations,
                       has_pressure ? "times two levels over CHOLMOD" : "factors by CHOLMOD");
}

void add_motion(core::Solution &solution, const Elements &elements, TetrahedronRule rule,
                const core::LoadCase &load_case, const State &start) {
    auto released = release(elements, rule, load_case, start.displacement);
    solution.history = std::move(released.history);
    solution.solver += fmt::format("; in time {} steps, {} iterations, {} factors", released.work.steps,
                                   released.work.iterations, released.work.factors);
    if (const double time = solution.history->diverged_at; !std::isnan(time)) {
        solution.status = core::SolutionStatus::diverged;
        solution.message = fmt::format("the motion finds no next step at t = {:.3g} s", time);
    }
}

} // namespace

PathSolution solve(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                   const LoadPath &path, std::span<const double> follower_pressure) {
    check(path);
    const auto &mesh = problem.body->mesh;
    fem_reference::check_facets(problem.load_case, mesh);
    const auto start = std::chrono::steady_clock::now();
    const auto rule = discretisation.degree == 1 ? TetrahedronRule::one_point : discretisation.rule;
    const Elements elements(problem.body, discretisation.degree, discretisation.formulation, law, rule);
    const auto conditions = fem_reference::dof_conditions(problem.load_case, elements.system());
    const std::chrono::duration<double> assembly = std::chrono::steady_clock::now() - start;
    const auto num_constraints = static_cast<int>(problem.load_case.constraint_names.size());
    const bool is_constrained = fem_reference::holds_every_part(problem.load_case, mesh);
    const auto followed =
        is_constrained ? follow(elements, conditions, num_constraints, follower_pressure, path)
                       : FollowedPath{.status = core::SolutionStatus::not_converged,
                                      .message = "the prescribed displacements leave the body, or a part of "
                                                 "it, free to move as a rigid body; constrain it in all six ways"};

    const auto at_mesh_nodes = [&](const std::vector<double> &displacement) {
        std::vector<Vector3> result;
        for (const int node : elements.system().mesh_node)
            result.emplace_back(Vector3::Map(&displacement[3 * node]));
        return result;
    };
    PathSolution result;
    for (const auto &point : followed.points)
        result.points.push_back({.fraction = point.fraction,
                                 .displacement = at_mesh_nodes(point.state.displacement),
                                 .reaction = point.reaction,
                                 .strain_energy = point.strain_energy,
                                 .smallest_jacobian = point.smallest_jacobian});
    result.steps = followed.steps;
    auto &solution = result.solution;
    solution.status = followed.status;
    solution.message = followed.message;
    solution.degrees_of_freedom = elements.num_displacements() + elements.num_pressures();
    solution.setup_seconds = assembly.count() + followed.setup_seconds;
    solution.solve_seconds = followed.solve_seconds;
    solution.solver = description(followed, elements.num_pressures() > 0);
    if (result.points.empty()) {
        solution.displacement.assign(mesh.points.size(), Vector3::Constant(nan));
        solution.reaction.assign(num_constraints, Vector3::Constant(nan));
        solution.strain_energy = nan;
    } else {
        const auto &end = result.points.back();
        solution.displacement = end.displacement;
        solution.reaction = end.reaction;
        solution.strain_energy = end.strain_energy;
        if (solution.status == core::SolutionStatus::ok)
            solution.nonlinearity = relative_difference(mesh, end.displacement, at_mesh_nodes(followed.linearised));
        if (solution.status == core::SolutionStatus::ok && problem.load_case.release &&
            discretisation.formulation == fem_reference::Formulation::displacement)
            add_motion(solution, elements, rule, problem.load_case, followed.points.back().state);
    }
    return result;
}

} // namespace livermark::hyperelastic
