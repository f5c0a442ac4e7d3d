#include "fem_reference/linear/linear_elasticity.hpp"

#include <deal.II/base/mpi.h>
#include <deal.II/lac/solver_cg.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <stdexcept>
#include <string>

#include "core/stopwatch.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/distributed/distributed_systems.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/facets.hpp"

namespace livermark::fem_reference {

namespace {

using core::Clock;
using core::seconds_since;

constexpr double tolerance_of_displacements = 1e-12;
constexpr double tolerance_of_mixed = 1e-10;

core::Solution free_to_move(const core::Problem &problem) {
    core::Solution solution;
    leave_unsolved(solution, problem.body->mesh, problem.load_case);
    solution.status = core::SolutionStatus::not_converged;
    solution.message = "the stiffness matrix is singular: the prescribed displacements leave the body, or a part of "
                       "it, free to move as a rigid body; constrain all six rigid body motions";
    return solution;
}

/// One problem as a rank works on it.
class RankProblem {
  public:
    RankProblem(const core::Problem &problem, const DistributedOptions &options)
        : rigid_(problem.body->mesh.points), scale_(pressure_scale(*problem.body)),
          press_resultants_(core::press_resultants(problem.load_case, problem.body->mesh)),
          part_(refined_part(problem, options)),
          matrices_(*part_.problem.body, options.degree, options.formulation, part_.problem.load_case.foundation),
          springs_(part_.problem.load_case.foundation, part_.problem.body->mesh, matrices_.system),
          conditions_(dof_conditions(part_.problem.load_case, matrices_.system)),
          nodes_(nodes_of(part_, matrices_.system), 3) {
        nodes_.share(conditions_.prescribed);
        is_free_ = free_of(conditions_.prescribed);
    }

    core::Solution solve(const DistributedOptions &options) {
        return options.formulation == Formulation::mixed ? solve_mixed(options) : solve_displacement(options);
    }

  private:
    static Part refined_part(const core::Problem &problem, const DistributedOptions &options) {
        auto part = cut(problem);
        for (int level = 0; level < options.num_refinements; ++level)
            part = refine(part);
        return part;
    }

    std::vector<double> prescribed_displacement() const {
        auto u = conditions_.prescribed;
        for (double &value : u)
            value = std::isnan(value) ? 0.0 : value;
        return u;
    }

    MatricesOfPart matrices_of_part() const {
        return {.stiffness = matrices_.system.stiffness,
                .divergence = matrices_.pressure.divergence,
                .compliance = matrices_.pressure.compliance};
    }

    /// K u + D^T p - f of the part, right where this rank owns it; and D u - C p.
    MixedField residual(const MixedField &state) const {
        MixedField out{std::vector<double>(state.u.size()), std::vector<double>(state.p.size())};
        matrices_of_part().apply(state.u, state.p, out.u, out.p);
        for (std::size_t dof = 0; dof < out.u.size(); ++dof)
            out.u[dof] -= conditions_.load[dof];
        return out;
    }

    core::Solution solve_displacement(const DistributedOptions &options) {
        auto start = Clock::now();
        const DistributedMultigrid levels(matrices_.system.stiffness, nodes_, matrices_.system.points, rigid_,
                                          is_free_);
        const DistributedStiffness<double> stiffness(matrices_.system.stiffness, nodes_, is_free_);
        core::Solution solution;
        solution.setup_seconds = assembly_seconds_ + seconds_since(start);
        start = Clock::now();
        MixedField state{prescribed_displacement(), {}};
        auto load = residual(state).u;
        for (std::size_t dof = 0; dof < load.size(); ++dof)
            load[dof] = is_free_[dof] ? -load[dof] : 0.0;
        auto right = nodes_.vector(), change = nodes_.vector();
        nodes_.write(std::span<const double>(load), right);
        const double size = right.l2_norm();
        dealii::SolverControl control(options.max_iterations, tolerance_of_displacements * size);
        try {
            dealii::SolverCG<NodeExchange::Vector>(control).solve(stiffness, change, right, levels);
        } catch (const dealii::SolverControl::NoConvergence &ending) {
            not_converged(solution, "conjugate gradients", static_cast<int>(ending.last_step),
                          ending.last_residual / size);
        }
        std::vector<double> found(state.u.size());
        nodes_.read(change, std::span(found));
        std::ranges::transform(state.u, found, state.u.begin(), std::plus<>());
        solution.solver = fmt::format("CG + ML on {} ranks, {} iterations, rigid body modes", support::mpi_num_ranks(),
                                      control.last_step());
        finish(solution, state, start);
        return solution;
    }

    core::Solution solve_mixed(const DistributedOptions &options) {
        auto start = Clock::now();
        DistributedSaddlePoint solver(part_, matrices_.system, matrices_.pressure, nodes_, rigid_, scale_, is_free_);
        solver.set_up(matrices_.system.stiffness);
        core::Solution solution;
        solution.setup_seconds = assembly_seconds_ + seconds_since(start);
        start = Clock::now();
        MixedField state{prescribed_displacement(), std::vector<double>(matrices_.pressure.num_pressures(), 0.0)};
        auto right = residual(state);
        for (auto *const values : {&right.u, &right.p})
            for (double &value : *values)
                value = -value;
        MixedField change;
        const auto ending = solver.solve(matrices_of_part(), right, tolerance_of_mixed, options.max_iterations, change);
        if (!ending.converged)
            not_converged(solution, "generalised minimal residuals", ending.iterations, ending.relative_residual);
        std::ranges::transform(state.u, change.u, state.u.begin(), std::plus<>());
        state.p = change.p;
        solution.degrees_of_freedom = solver.pressures().num_entries_of_all_ranks();
        solution.solver =
            fmt::format("GMRES on {} ranks, {} iterations, two levels over ML and the mass of the pressure, {} nodes "
                        "of others on a rank at most",
                        support::mpi_num_ranks(), ending.iterations,
                        dealii::Utilities::MPI::max(nodes_.num_received(), MPI_COMM_WORLD));
        finish(solution, state, start);
        return solution;
    }

    static void not_converged(core::Solution &solution, const char *method, int iterations, double residual) {
        solution.status = core::SolutionStatus::not_converged;
        solution.message = fmt::format("{} stopped after {} iterations at a relative residual of {:.1e}; run without "
                                       "mpirun, where there are other solvers",
                                       method, iterations, residual);
    }

    /// Over what all ranks own.
    double dot(const std::vector<double> &a, const std::vector<double> &b) const {
        double sum = 0.0;
        for (const int node : nodes_.owned())
            for (auto dof = 3 * static_cast<std::size_t>(node); dof < 3 * static_cast<std::size_t>(node) + 3; ++dof)
                sum += a[dof] * b[dof];
        return dealii::Utilities::MPI::sum(sum, MPI_COMM_WORLD);
    }

    void finish(core::Solution &solution, MixedField state, Clock::time_point start) const {
        auto left = residual(state);
        double newtons = 1.0;
        if (conditions_.press_depth != 0.0) { // what one newton does, multiplied by as many as it takes
            newtons = conditions_.press_depth / dot(state.u, conditions_.load);
            for (auto *const values : {&state.u, &left.u})
                for (double &value : *values)
                    value *= newtons;
        }
        // u . (K u + D^T p), which is u . K u + p . C p as D u = C p
        solution.strain_energy = 0.5 * (dot(state.u, left.u) + newtons * dot(state.u, conditions_.load));
        std::vector<double> spring_force(state.u.size(), 0.0); // its energy is not one of the body
        springs_.add_force(state.u, spring_force);
        solution.strain_energy -= 0.5 * dot(state.u, spring_force);
        if (const auto &load_case = part_.problem.load_case;
            load_case.press_depth == 0.0 && load_case.acceleration.isZero(0.0))
            solution.load_work = dot(state.u, conditions_.load);
        solution.degrees_of_freedom += 3 * nodes_.num_entries_of_all_ranks();
        solution.reaction =
            sum_of_reactions(nodes_, conditions_.constraint, left.u, part_.problem.load_case.num_constraints());
        for (std::size_t place = 0; place < press_resultants_.size(); ++place)
            solution.reaction[place] += newtons * press_resultants_[place];
        solution.displacement = on_mesh(part_, matrices_.system, nodes_, state.u);
        solution.solve_seconds = seconds_since(start);
    }

    Clock::time_point start_ = Clock::now();
    RigidModes rigid_;
    double scale_; ///< of pressures [Pa/m]
    std::vector<core::Vector3> press_resultants_;
    Part part_;
    Discretisation matrices_;
    FoundationSprings springs_; ///< a part of the stiffness
    DofConditions conditions_;
    NodeExchange nodes_;
    std::vector<bool> is_free_;
    double assembly_seconds_ = seconds_since(start_);
};

} // namespace

core::Solution solve_distributed(const core::Problem &problem, const DistributedOptions &options) {
    // A wrong problem is wrong on every rank, and can be thrown without leaving one behind.
    if (options.degree != 1 && options.degree != 2)
        throw std::invalid_argument("finite elements of degree " + std::to_string(options.degree) +
                                    " are not there; use 1 or 2");
    if (options.degree == 1 && options.formulation == Formulation::mixed)
        throw std::invalid_argument("the mixed formulation takes quadratic elements");
    check_facets(problem.load_case, problem.body->mesh);
    check_outer_faces(problem.body->mesh);
    if (!holds_every_part(problem.load_case, problem.body->mesh))
        return free_to_move(problem);
    return on_all_ranks([&] { return RankProblem(problem, options).solve(options); });
}

} // namespace livermark::fem_reference
