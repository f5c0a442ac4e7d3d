#include "fem_reference/distributed/distributed_solver.hpp"

#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/trilinos_precondition.h>

#include <chrono>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

#include "core/stopwatch.hpp"
#include "fem_reference/distributed/distributed_system.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/solvers/multigrid_settings.hpp"
#include "support/mpi_session.hpp"

namespace livermark::fem_reference {

namespace {

using core::Clock;
using core::seconds_since;

constexpr double residual_tolerance = 1e-12;

core::Solution free_to_move(const core::Problem &problem) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    core::Solution solution;
    solution.status = core::SolutionStatus::not_converged;
    solution.message = "the stiffness matrix is singular: the prescribed displacements leave the body, or a part of "
                       "it, free to move as a rigid body; constrain all six rigid body motions";
    solution.displacement.assign(problem.body->mesh.points.size(), core::Vector3::Constant(nan));
    solution.reaction.assign(problem.load_case.constraint_names.size(), core::Vector3::Constant(nan));
    solution.strain_energy = nan;
    return solution;
}

core::Solution solve(const core::Problem &problem, int degree, int max_iterations) {
    const auto start = Clock::now();
    const DistributedSystem system(problem, degree);
    const auto matrix = system.stiffness();
    auto modes = system.rigid_modes();
    dealii::TrilinosWrappers::PreconditionAMG levels;
    auto settings = multigrid_settings(modes);
    levels.initialize(matrix, settings);

    core::Solution solution;
    solution.degrees_of_freedom = system.num_unknowns();
    solution.setup_seconds = seconds_since(start);
    const auto solve_start = Clock::now();
    const auto right_hand_side = system.right_hand_side();
    const double size = right_hand_side.l2_norm();
    DistributedSystem::Vector u;
    u.reinit(right_hand_side);
    dealii::SolverControl control(max_iterations, residual_tolerance * size);
    try {
        dealii::SolverCG<DistributedSystem::Vector>(control).solve(matrix, u, right_hand_side, levels);
    } catch (const dealii::SolverControl::NoConvergence &ending) {
        solution.status = core::SolutionStatus::not_converged;
        solution.message =
            fmt::format("conjugate gradients stopped after {} iterations at a relative residual of {:.1e}; "
                        "run without mpirun, where there are other solvers",
                        ending.last_step, ending.last_residual / size);
    }
    system.impose(u);
    const auto residual = system.residual(u);
    solution.displacement = system.on_mesh(u);
    solution.reaction = system.reactions(residual);
    for (auto &reaction : solution.reaction)
        for (double &component : reaction)
            component = dealii::Utilities::MPI::sum(component, MPI_COMM_WORLD);
    solution.strain_energy = dealii::Utilities::MPI::sum(residual.energy, MPI_COMM_WORLD);
    solution.solver = fmt::format("CG + ML on {} ranks, {} iterations, rigid body modes", support::mpi_num_ranks(),
                                  control.last_step());
    solution.solve_seconds = seconds_since(solve_start);
    return solution;
}

} // namespace

core::Solution solve_distributed(const core::Problem &problem, int degree, int max_iterations) {
    // What is wrong with the problem is wrong on every rank, and can be thrown without leaving one behind.
    if (degree != 1 && degree != 2)
        throw std::invalid_argument("finite elements of degree " + std::to_string(degree) +
                                    " are not there; use 1 or 2");
    check_facets(problem.load_case, problem.body->mesh);
    check_outer_faces(problem.body->mesh);
    if (!holds_every_part(problem.load_case, problem.body->mesh))
        return free_to_move(problem);
    try {
        return solve(problem, degree, max_iterations);
    } catch (const std::exception &error) {
        if (support::mpi_num_ranks() == 1)
            throw;
        support::abort_all_ranks(error.what());
    }
}

} // namespace livermark::fem_reference
