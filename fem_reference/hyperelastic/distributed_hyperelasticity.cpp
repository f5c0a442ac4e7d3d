#include "fem_reference/hyperelastic/distributed_hyperelasticity.hpp"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "core/stopwatch.hpp"
#include "fem_reference/distributed/distributed_saddle_point.hpp"
#include "fem_reference/distributed/ranks.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/hyperelastic/one_process_system.hpp"
#include "fem_reference/hyperelastic/path_solution.hpp"
#include "support/mpi_session.hpp"

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
    /// @param whole             of which the part was cut
    /// @param follower_pressure  of the facets of the part
    DistributedSystem(const core::Problem &whole, Part part, const MaterialLaw &law,
                      std::span<const double> follower_pressure)
        : part_(std::move(part)),
          elements_(part_.problem.body, 2, fem_reference::Formulation::mixed, law, TetrahedronRule::fourteen_points),
          scale_(fem_reference::pressure_scale(*whole.body)), volume_(volume_of(whole.body->mesh)),
          conditions_(shared_conditions(part_, elements_)),
          follower_(elements_.system(), part_.problem.body->mesh, follower_pressure),
          solver_(part_, elements_.system(), elements_.pressure(), fem_reference::RigidModes(whole.body->mesh.points),
                  scale_, free_of(conditions_.prescribed)),
          tangent_(elements_.zero_tangent()), energy_share_(energy_shares(part_)),
          counted_displacements_(owned_entries(solver_.nodes(), 3)),
          counted_pressures_(owned_entries(solver_.pressures(), 1)) {}

    const fem_reference::DofConditions &conditions() const override { return conditions_; }
    State rest() const override { return elements_.rest(); }
    InternalForces internal_forces(const State &state) const override {
        auto forces = elements_.internal_forces(state, energy_share_);
        forces.smallest_jacobian = dealii::Utilities::MPI::min(forces.smallest_jacobian, MPI_COMM_WORLD);
        forces.energy = sum(forces.energy);
        return forces;
    }
    std::vector<double> loads(const State &state, double fraction) const override {
        return loads_at(conditions_, follower_, state, fraction);
    }
    void assemble(const State &state, double fraction) override {
        elements_.assemble_tangent(state, tangent_);
        load_stiffness_ = follower_.load_stiffness(fraction, state.displacement);
        follower_.add_symmetric_part(load_stiffness_, tangent_.stiffness);
    }
    /// Multigrid does not tell whether a matrix is positive definite: iterations that do not converge do.
    bool factorise() override {
        solver_.set_up(tangent_.stiffness);
        return true;
    }
    bool factorise_at_rest() override {
        auto at_rest = elements_.zero_tangent();
        elements_.assemble_tangent(elements_.rest(), at_rest);
        solver_.set_up(at_rest.stiffness);
        return true;
    }
    TangentSolver::Correction solve(const State &right, double tolerance) const override {
        MixedField change;
        const auto ending = solver_.solve(
            {.stiffness = tangent_.stiffness,
             .divergence = tangent_.divergence,
             .compliance = elements_.compliance(),
             .add_product = [&](auto x, auto out) { follower_.add_antisymmetric_product(load_stiffness_, x, out); }},
            {right.displacement, right.pressure}, tolerance, TangentSolver::max_iterations, change);
        return {.converged = ending.converged,
                .iterations = ending.iterations,
                .change = {std::move(change.u), std::move(change.p)}};
    }
    State product(const std::vector<double> &u) const override {
        State result{std::vector<double>(u.size()), std::vector<double>(elements_.num_pressures(), 0.0)};
        tangent_.stiffness.multiply(u, result.displacement);
        follower_.add_antisymmetric_product(load_stiffness_, u, result.displacement);
        if (!result.pressure.empty()) {
            const std::vector<double> nothing(result.pressure.size(), 0.0);
            tangent_.divergence.subtract_product(u, nothing, result.pressure, 1);
        }
        return result;
    }
    double pressure_scale() const override { return scale_; }
    bool is_direct() const override { return false; }
    double volume() const override { return volume_; }
    const std::vector<bool> &counted_displacements() const override { return counted_displacements_; }
    const std::vector<bool> &counted_pressures() const override { return counted_pressures_; }
    double sum(double mine) const override { return dealii::Utilities::MPI::sum(mine, MPI_COMM_WORLD); }

    std::int64_t num_unknowns() const {
        return 3 * solver_.nodes().num_entries_of_all_ranks() + solver_.pressures().num_entries_of_all_ranks();
    }
    std::vector<core::Vector3> at_mesh_nodes(const std::vector<double> &displacement) const {
        return fem_reference::on_mesh(part_, elements_.system(), solver_.nodes(), displacement);
    }

  private:
    static double volume_of(const core::TetraMesh &mesh) {
        const auto volumes = core::tetrahedron_volumes(mesh);
        return std::accumulate(volumes.begin(), volumes.end(), 0.0);
    }
    /// What is prescribed is known here where other ranks own it, too.
    static fem_reference::DofConditions shared_conditions(const Part &part, const Elements &elements) {
        auto conditions = fem_reference::dof_conditions(part.problem.load_case, elements.system());
        fem_reference::NodeExchange(fem_reference::nodes_of(part, elements.system()), 3).share(conditions.prescribed);
        return conditions;
    }

    Part part_;
    Elements elements_;
    double scale_, volume_;
    fem_reference::DofConditions conditions_;
    FollowerPressure follower_;
    fem_reference::DistributedSaddlePoint solver_;
    TangentMatrices tangent_;
    FollowerPressure::LoadStiffness load_stiffness_;
    std::vector<double> energy_share_;
    std::vector<bool> counted_displacements_, counted_pressures_;
};

PathSolution solve_on_part(const core::Problem &problem, const MaterialLaw &law, const LoadPath &path,
                           std::span<const double> follower_pressure) {
    const auto start = core::Clock::now();
    auto part = fem_reference::cut(problem);
    std::vector<double> of_part;
    if (!follower_pressure.empty())
        for (const int facet : part.facet)
            of_part.push_back(follower_pressure[facet]);
    DistributedSystem system(problem, std::move(part), law, of_part);
    const double assembly_seconds = core::seconds_since(start);
    const auto num_constraints = static_cast<int>(problem.load_case.constraint_names.size());
    const auto followed = follow(system, num_constraints, path);
    auto result = path_solution(followed, problem.body->mesh, num_constraints,
                                [&](const std::vector<double> &u) { return system.at_mesh_nodes(u); });
    result.solution.degrees_of_freedom = system.num_unknowns();
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
        return path_solution(free_to_move(), mesh, static_cast<int>(problem.load_case.constraint_names.size()), {});
    return fem_reference::on_all_ranks([&] { return solve_on_part(problem, law, path, follower_pressure); });
}

} // namespace livermark::hyperelastic
