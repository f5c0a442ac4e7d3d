#include "fem_reference/linear/repeated_loads.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <optional>
#include <utility>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/place_weights.hpp"
#include "fem_reference/solvers/iterative_solver.hpp"
#include "fem_reference/solvers/multigrid/two_level.hpp"

namespace livermark::fem_reference {

struct RepeatedLoads::Impl {
    /// What iterations on two levels need.
    struct Levels {
        Levels(const core::Body &body, const ElasticSystem &fine)
            : coarse(assemble(body, 1)), coarse_solver(coarse, SolverChoice::automatic),
              rounded_fine(rounded(fine.stiffness)),
              solver(fine.stiffness, two_level(prolongation(coarse, fine), rounded_fine, coarse_solver.inverse())) {}

        ElasticSystem coarse;
        ChosenSolver coarse_solver;
        SymmetricBlocks<float> rounded_fine;
        IterativeSolver solver;
    };

    core::TetraMesh mesh;
    ElasticSystem system; ///< without its matrix where there is a factor
    std::optional<ConstrainedSolver> factor;
    std::optional<Levels> levels;

    /// Of the places that were asked for last: the forces of a needle change more often than its line.
    struct Places {
        std::vector<core::InteriorPlace> places;
        Eigen::SparseMatrix<double, Eigen::RowMajor> weights; ///< (K, n)
    };
    std::optional<Places> last_places;

    const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights_of(const std::vector<core::InteriorPlace> &places) {
        const auto are_equal = [](const core::InteriorPlace &a, const core::InteriorPlace &b) {
            return a.middle == b.middle && a.radius == b.radius;
        };
        if (!last_places || !std::ranges::equal(last_places->places, places, are_equal))
            last_places = Places{places, place_weights(places, system, mesh)};
        return last_places->weights;
    }
};

RepeatedLoads::RepeatedLoads(const core::Body &body, const core::LoadCase &constrained,
                             const std::function<void(const std::string &)> &report, int largest)
    : impl_(std::make_unique<Impl>()) {
    check_facets(constrained, body.mesh);
    report(fmt::format("Quadratic elements are being assembled: {} tetrahedra.", body.mesh.num_tetrahedra()));
    auto &[mesh, system, factor, levels, last_places] = *impl_;
    mesh = body.mesh;
    system = assemble(body, 2, NodeOrder::by_distance);
    const auto prescribed = dof_conditions(constrained, system).prescribed;
    const auto num_unknowns = prescribed.size();
    if (num_unknowns <= static_cast<std::size_t>(largest)) {
        report(fmt::format("Their stiffness is being factorised, once for all solutions: {} unknowns.", num_unknowns));
        factor.emplace(compressed_rows(system.stiffness));
        system.stiffness = {}; // the solver has its own
        factor->factorise(prescribed);
    } else {
        report(fmt::format("Two levels of elements are being prepared, once for all solutions: {} unknowns.",
                           num_unknowns));
        levels.emplace(body, system);
        levels->solver.set_up(prescribed);
    }
}

RepeatedLoads::~RepeatedLoads() = default;

RepeatedLoads::Solution RepeatedLoads::solve(const core::LoadCase &load_case, std::vector<double> &last,
                                             const InnerForces &inner) {
    auto &[mesh, system, factor, levels, last_places] = *impl_;
    auto conditions = dof_conditions(load_case, system);
    using Nodes = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const auto &weights = impl_->weights_of(inner.places);
    Nodes forces(weights.rows(), 3);
    for (Eigen::Index k = 0; k < forces.rows(); ++k)
        forces.row(k) = inner.forces[static_cast<std::size_t>(k)];
    Eigen::Map<Nodes>(conditions.load.data(), weights.cols(), 3) += weights.transpose() * forces;
    auto found = factor ? factor->solve(conditions.prescribed, conditions.load)
                        : levels->solver.solve(conditions.prescribed, conditions.load, {last, tolerance});
    Solution solution{.is_unique = found.unique,
                      .has_converged = found.unique && found.converged,
                      .iterations = found.iterations,
                      .displacement = {},
                      .at_places = {}};
    if (!found.unique)
        return solution;
    solution.displacement.resize(mesh.points.size());
    for (int node = 0; node < mesh.num_nodes(); ++node)
        for (int i = 0; i < 3; ++i)
            solution.displacement[node][i] = found.displacement[3 * system.mesh_node[node] + i];
    solution.work = std::inner_product(conditions.load.begin(), conditions.load.end(), found.displacement.begin(), 0.0);
    const Nodes means = weights * Eigen::Map<const Nodes>(found.displacement.data(), weights.cols(), 3);
    for (const auto &mean : means.rowwise())
        solution.at_places.emplace_back(mean);
    last.clear();
    if (solution.has_converged)
        last = std::move(found.displacement);
    return solution;
}

} // namespace livermark::fem_reference
