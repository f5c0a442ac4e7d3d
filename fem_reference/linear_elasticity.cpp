#include "fem_reference/linear_elasticity.hpp"

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

#include "fem_reference/chosen_solver.hpp"
#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/elastic_system.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/release.hpp"

namespace livermark::fem_reference {

namespace {

using Clock = std::chrono::steady_clock;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

} // namespace

struct StaticSolver::Impl {
    Impl(std::shared_ptr<const core::Body> of, int degree, SolverChoice choice)
        : body(std::move(of)), start(Clock::now()), system(assemble(*body, degree)), solver(system, choice),
          assembly_seconds(seconds_since(start)) {}
    Impl(std::shared_ptr<const core::Body> refined, Impl &coarse)
        : body(std::move(refined)), start(Clock::now()), system(assemble(*body, 2)),
          solver(system, coarse.system, coarse.solver), assembly_seconds(seconds_since(start)) {}

    std::shared_ptr<const core::Body> body;
    Clock::time_point start;
    ElasticSystem system;
    ChosenSolver solver;
    double assembly_seconds;
};

StaticSolver::StaticSolver(std::shared_ptr<const core::Body> body, int degree, SolverChoice choice)
    : impl_(std::make_unique<Impl>(std::move(body), degree, choice)) {}
StaticSolver::StaticSolver(std::shared_ptr<const core::Body> refined_body, StaticSolver &coarse)
    : impl_(std::make_unique<Impl>(std::move(refined_body), *coarse.impl_)) {}
StaticSolver::~StaticSolver() = default;
StaticSolver::StaticSolver(StaticSolver &&) noexcept = default;
StaticSolver &StaticSolver::operator=(StaticSolver &&) noexcept = default;

core::Solution StaticSolver::solve(const core::LoadCase &load_case) {
    const auto &mesh = impl_->body->mesh;
    check_facets(load_case, mesh);
    const auto conditions_start = Clock::now();
    const auto conditions = dof_conditions(load_case, impl_->system);
    const double conditions_seconds = seconds_since(conditions_start);
    impl_->solver.set_up(conditions.prescribed);
    const auto solve_start = Clock::now();
    const auto found = impl_->solver.solve(conditions.prescribed, conditions.load);

    core::Solution solution;
    solution.degrees_of_freedom = static_cast<std::int64_t>(conditions.load.size());
    solution.displacement.assign(mesh.points.size(), core::Vector3::Constant(nan));
    if (found.unique) {
        for (int node = 0; node < mesh.num_nodes(); ++node)
            for (int i = 0; i < 3; ++i)
                solution.displacement[node][i] = found.displacement[3 * node + i];
        solution.reaction.assign(load_case.constraint_names.size(), core::Vector3::Zero());
        for (std::size_t dof = 0; dof < conditions.constraint.size(); ++dof)
            if (const int owner = conditions.constraint[dof]; owner >= 0)
                solution.reaction[owner][dof % 3] += found.residual[dof];
        solution.strain_energy = found.energy;
        if (!found.converged) {
            solution.status = core::SolutionStatus::not_converged;
            solution.message = fmt::format("conjugate gradients stopped after {} iterations at a relative residual of "
                                           "{:.1e}; use the direct solver",
                                           found.iterations, found.relative_residual);
        }
    } else {
        solution.status = core::SolutionStatus::not_converged;
        solution.message = "the stiffness matrix is singular: the prescribed displacements leave the body, or a part "
                           "of it, free to move as a rigid body; hold it in all six ways";
        solution.reaction.assign(load_case.constraint_names.size(), core::Vector3::Constant(nan));
        solution.strain_energy = nan;
    }
    solution.solver = impl_->solver.description(found);
    solution.setup_seconds = impl_->assembly_seconds + impl_->solver.setup_seconds();
    solution.solve_seconds = conditions_seconds + seconds_since(solve_start);
    if (load_case.release && found.unique)
        solution.history = release(*impl_->body, impl_->system, load_case, found.displacement);
    return solution;
}

core::Solution solve_static(const core::Problem &problem, int degree, SolverChoice choice) {
    return StaticSolver(problem.body, degree, choice).solve(problem.load_case);
}

} // namespace livermark::fem_reference
