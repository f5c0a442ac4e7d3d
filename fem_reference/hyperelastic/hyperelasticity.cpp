#include "fem_reference/hyperelastic/hyperelasticity.hpp"

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/hyperelastic/motion/hyperelastic_motion.hpp"
#include "fem_reference/hyperelastic/paths/path_solution.hpp"
#include "fem_reference/hyperelastic/surface/surface_deformation.hpp"

namespace livermark::hyperelastic {

namespace {

using core::Vector3;

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

/// For the result file.
std::string touched(const TouchSums &touch) {
    return fmt::format("; touches on {:.4g} mm2, of which {:.3g} % slip", 1e6 * touch.area,
                       touch.area > 0.0 ? 100.0 * touch.slipping_area / touch.area : 0.0);
}

/// Why a path ended, if the load is why: it keeps its direction, and the surface below cannot bear that.
std::string instability(const Elements &elements, const core::LoadCase &load_case, const FollowedPath &followed) {
    constexpr int quadratic = 2;
    if (followed.status == core::SolutionStatus::ok || followed.points.empty() || elements.degree() != quadratic)
        return {};
    const auto &end = followed.points.back();
    const double part =
        unstable_part(elements, load_case, end.state.displacement, end.press > 0.0 ? end.press : end.fraction);
    constexpr double percent = 100.0;
    return part > 0.0 ? fmt::format("; there the surface cannot resist short waves on {:.0f} % of the area under loads "
                                    "that keep their direction",
                                    percent * part)
                      : std::string();
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
    std::optional<TouchingBall> ball;
    if (problem.load_case.touching)
        ball.emplace(elements.system(), *problem.body, problem.load_case);
    const std::chrono::duration<double> assembly = std::chrono::steady_clock::now() - start;
    const auto num_constraints = problem.load_case.num_constraints();
    const auto followed =
        fem_reference::holds_every_part(problem.load_case, mesh)
            ? follow(elements, conditions, num_constraints, follower_pressure, path, ball ? &*ball : nullptr)
            : free_to_move();
    const auto at_mesh_nodes = [&](const std::vector<double> &displacement) {
        std::vector<Vector3> result;
        for (const int node : elements.system().mesh_node)
            result.emplace_back(Vector3::Map(&displacement[3 * node]));
        return result;
    };
    auto result = path_solution(followed, mesh, problem.load_case, at_mesh_nodes);
    auto &solution = result.solution;
    if (solution.status == core::SolutionStatus::ok)
        result.load_work = std::inner_product(conditions.load.begin(), conditions.load.end(),
                                              followed.points.back().state.displacement.begin(), 0.0);
    solution.degrees_of_freedom = elements.num_displacements() + elements.num_pressures();
    solution.setup_seconds += assembly.count();
    solution.solver =
        description(followed, elements.num_pressures() > 0 ? "times two levels over CHOLMOD" : "factors by CHOLMOD");
    solution.message += instability(elements, problem.load_case, followed);
    if (ball && !followed.points.empty())
        solution.solver += touched(followed.points.back().touch);
    if (solution.status == core::SolutionStatus::ok && problem.load_case.release &&
        discretisation.formulation == fem_reference::Formulation::displacement)
        add_motion(solution, elements, rule, problem.load_case, followed.points.back().state);
    return result;
}

} // namespace livermark::hyperelastic
