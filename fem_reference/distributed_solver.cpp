#include "fem_reference/distributed_solver.hpp"

#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/trilinos_precondition.h>

#include <Teuchos_ParameterList.hpp>
#include <chrono>
#include <fmt/format.h>
#include <limits>
#include <ml_MultiLevelPreconditioner.h>
#include <stdexcept>

#include "fem_reference/distributed_system.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/mpi_session.hpp"

namespace livermark::fem_reference {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double tolerance = 1e-12;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

core::Solution free_to_move(const core::Problem &problem) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    core::Solution solution;
    solution.status = core::SolutionStatus::not_converged;
    solution.message = "the stiffness matrix is singular: the prescribed displacements leave the body, or a part of "
                       "it, free to move as a rigid body; hold it in all six ways";
    solution.displacement.assign(problem.body->mesh.points.size(), core::Vector3::Constant(nan));
    solution.reaction.assign(problem.load_case.constraint_names.size(), core::Vector3::Constant(nan));
    solution.strain_energy = nan;
    return solution;
}

/// @param modes  near-nullspace of the rows of this rank; read while the levels are made
void set_up_levels(dealii::TrilinosWrappers::PreconditionAMG &levels,
                   const dealii::TrilinosWrappers::SparseMatrix &matrix, std::vector<double> &modes) {
    Teuchos::ParameterList list;
    ML_Epetra::SetDefaults("SA", list);
    list.set("ML output", 0);
    list.set("PDE equations", 3);
    list.set("null space: type", "pre-computed");
    list.set("null space: dimension", 6);
    list.set("null space: vectors", modes.data());
    list.set("aggregation: type", "Uncoupled");
    list.set("aggregation: threshold", 1e-4);
    list.set("smoother: type", "symmetric Gauss-Seidel");
    list.set("smoother: sweeps", 1);
    list.set("smoother: pre or post", "both");
    list.set("coarse: type", "Amesos-KLU");
    list.set("coarse: max size", 2000);
    levels.initialize(matrix, list);
}

core::Solution solve(const core::Problem &problem, int degree, int max_iterations) {
    const auto start = Clock::now();
    const DistributedSystem system(problem, degree);
    const auto matrix = system.stiffness();
    auto modes = system.rigid_modes();
    dealii::TrilinosWrappers::PreconditionAMG levels;
    set_up_levels(levels, matrix, modes);

    core::Solution solution;
    solution.degrees_of_freedom = system.num_unknowns();
    solution.setup_seconds = seconds_since(start);
    const auto solve_start = Clock::now();
    const auto right_hand_side = system.right_hand_side();
    const double size = right_hand_side.l2_norm();
    DistributedSystem::Vector u;
    u.reinit(right_hand_side);
    dealii::SolverControl control(max_iterations, tolerance * size);
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
    solution.solver =
        fmt::format("CG + ML on {} ranks, {} iterations, rigid body modes", mpi_num_ranks(), control.last_step());
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
        if (mpi_num_ranks() == 1)
            throw;
        abort_all_ranks(error.what());
    }
}

} // namespace livermark::fem_reference
