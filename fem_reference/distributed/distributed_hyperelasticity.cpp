#include "fem_reference/hyperelastic/hyperelasticity.hpp"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

#include "core/stopwatch.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/distributed/distributed_systems.hpp"
#include "fem_reference/hyperelastic/equilibrium_search.hpp"
#include "fem_reference/linear/conditions.hpp"

namespace livermark::hyperelastic {

namespace {

using fem_reference::MixedField;
using fem_reference::Part;

/// (M') how many of the corners of each tetrahedron a rank owns, over four: over all ranks they sum to one.
std::vector<double> energy_shares(const Part &part) {
    std::vector<double> shares;
    for (const auto &corners : part.problem.body->mesh.tetrahedra)
        shares.push_back(0.25 * static_cast<double>(std::ranges::count_if(corners, [&](int node) {
                             return part.vertex_owner[node] == support::mpi_rank();
                         })));
    return shares;
}

std::vector<bool> owned_entries(const fem_reference::NodeExchange &exchange, int components) {
    std::vector<bool> is_owned;
    for (std::size_t entry = 0; entry < exchange.numbers().size(); ++entry)
        is_owned.insert(is_owned.end(), components, exchange.owns(entry));
    return is_owned;
}

/// The part of a rank of elements that are spread over all.
class DistributedSystem : public PathSystem {
  public:
    /// All are kept alive by the caller.
    /// @param whole       body of which the part was cut
    /// @param nodes       of the elements, three components each
    /// @param conditions  what is prescribed right for what other ranks own, too
    /// @param pressure    of the facets of the part
    DistributedSystem(const core::Body &whole, const Part &part, const Elements &elements,
                      const fem_reference::NodeExchange &nodes, const fem_reference::DofConditions &conditions,
                      std::span<const double> pressure)
        : PathSystem(elements, conditions, pressure), scale_(fem_reference::pressure_scale(whole)),
          volume_(volume_of(whole.mesh)),
          solver_(part, elements.system(), elements.pressure(), nodes, fem_reference::RigidModes(whole.mesh.points),
                  scale_, fem_reference::free_of(conditions.prescribed)),
          energy_share_(energy_shares(part)), counted_displacements_(owned_entries(nodes, 3)),
          counted_pressures_(owned_entries(solver_.pressures(), 1)) {}

    InternalForces internal_forces(const State &state) const override {
        auto forces = elements().internal_forces(state, energy_share_);
        forces.smallest_jacobian = dealii::Utilities::MPI::min(forces.smallest_jacobian, MPI_COMM_WORLD);
        forces.energy = sum(forces.energy);
        return forces;
    }
    TangentSolver::Correction solve(const State &right, double tolerance) const override {
        MixedField change;
        const auto ending =
            solver_.solve({.stiffness = tangent().stiffness,
                           .divergence = tangent().divergence,
                           .compliance = elements().compliance(),
                           .add_product = [&](auto x, auto out) { surface_stiffness().add_product(x, out); }},
                          {right.displacement, right.pressure}, tolerance, TangentSolver::max_iterations, change);
        return {.converged = ending.converged,
                .iterations = ending.iterations,
                .change = {std::move(change.u), std::move(change.p)}};
    }
    double pressure_scale() const override { return scale_; }
    bool is_direct() const override { return false; }
    double volume() const override { return volume_; }
    const std::vector<bool> &counted_displacements() const override { return counted_displacements_; }
    const std::vector<bool> &counted_pressures() const override { return counted_pressures_; }
    double sum(double mine) const override { return dealii::Utilities::MPI::sum(mine, MPI_COMM_WORLD); }

    std::int64_t num_pressures_of_all_ranks() const { return solver_.pressures().num_entries_of_all_ranks(); }

  private:
    /// Multigrid does not tell whether a matrix is positive definite: iterations that do not converge do.
    bool set_up(const fem_reference::SymmetricBlocks<double> &stiffness) override {
        solver_.set_up(stiffness);
        return true;
    }

    double scale_, volume_;
    fem_reference::DistributedSaddlePoint solver_;
    std::vector<double> energy_share_;
    std::vector<bool> counted_displacements_, counted_pressures_;
};

PathSolution solve_on_part(const core::Problem &problem, const MaterialLaw &law, const LoadPath &path,
                           std::span<const double> follower_pressure) {
    const auto start = core::Clock::now();
    const auto part = fem_reference::cut(problem);
    std::vector<double> pressure_on_part;
    if (!follower_pressure.empty())
        for (const int facet : part.facet)
            pressure_on_part.push_back(follower_pressure[facet]);
    const Elements elements(part.problem.body, 2, fem_reference::Formulation::mixed, law,
                            TetrahedronRule::fourteen_points);
    const fem_reference::NodeExchange nodes(fem_reference::nodes_of(part, elements.system()), 3);
    auto conditions = fem_reference::dof_conditions(part.problem.load_case, elements.system());
    nodes.share(conditions.prescribed);
    DistributedSystem system(*problem.body, part, elements, nodes, conditions, pressure_on_part);
    const double assembly_seconds = core::seconds_since(start);
    const auto num_constraints = problem.load_case.num_constraints();
    const auto followed = follow(system, num_constraints, path);
    auto result = path_solution(followed, problem.body->mesh, problem.load_case, [&](const std::vector<double> &u) {
        return fem_reference::on_mesh(part, elements.system(), nodes, u);
    });
    result.solution.degrees_of_freedom = 3 * nodes.num_entries_of_all_ranks() + system.num_pressures_of_all_ranks();
    result.solution.setup_seconds += assembly_seconds;
    result.solution.solver =
        description(followed, fmt::format("times two levels over ML, on {} ranks", support::mpi_num_ranks()));
    return result;
}

} // namespace

PathSolution solve_distributed(const core::Problem &problem, const MaterialLaw &law, const LoadPath &path,
                               std::span<const double> follower_pressure) {
    check(path);
    const auto &mesh = problem.body->mesh;
    fem_reference::check_facets(problem.load_case, mesh);
    fem_reference::check_outer_faces(mesh);
    if (!follower_pressure.empty() && follower_pressure.size() != mesh.boundary_triangles.size())
        throw std::invalid_argument("a follower pressure is needed for each boundary triangle");
    if (!fem_reference::holds_every_part(problem.load_case, mesh))
        return path_solution(free_to_move(), mesh, problem.load_case, {});
    return fem_reference::on_all_ranks([&] { return solve_on_part(problem, law, path, follower_pressure); });
}

} // namespace livermark::hyperelastic
