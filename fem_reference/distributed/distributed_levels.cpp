#include "fem_reference/distributed/distributed_levels.hpp"

#include <deal.II/lac/precondition.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "fem_reference/distributed/distributed_multigrid.hpp"
#include "fem_reference/distributed/distributed_stiffness.hpp"
#include "fem_reference/solvers/clear_constrained.hpp"
#include "fem_reference/solvers/multigrid/prolongation.hpp"
#include "fem_reference/solvers/multigrid/two_level.hpp"

namespace livermark::fem_reference {

namespace {

using Smoothed = DistributedStiffness<float>;
using Chebyshev = dealii::PreconditionChebyshev<Smoothed, NodeExchange::Vector, BlockJacobi>;

/// Products before and behind the correction, and over which part of the spectrum they act: beyond that linear elements
/// see what is left.
constexpr unsigned int smoother_degree = 3;
constexpr double smoothing_range = 12.0;
constexpr unsigned int eigenvalue_iterations = 12;

} // namespace

struct DistributedLevels::Impl {
    Impl(const Part &part, const ElasticSystem &of_quadratic, const NodeExchange &of_nodes, const RigidModes &of_body,
         const std::vector<bool> &free)
        : quadratic(of_quadratic), nodes(of_nodes), rigid(of_body), is_free(free),
          linear(assemble(without_pressure(*part.problem.body), 1)), vertices(nodes_of(part, linear), 3),
          from_linear(prolongation(linear, quadratic)), is_vertex_free(3 * linear.points.size()),
          residual(vertices.vector()), correction(vertices.vector()) {
        for (std::size_t dof = 0; dof < is_vertex_free.size(); ++dof)
            is_vertex_free[dof] = is_free[3 * from_linear.fine_node[dof / 3] + dof % 3];
        fine_values.resize(3 * quadratic.points.size());
        coarse_values.resize(is_vertex_free.size());
    }

    /// out += the correction of linear elements for what in is without out.
    void correct(NodeExchange::Vector &out, const NodeExchange::Vector &in) const {
        auto left = nodes.vector();
        smoothed->vmult(left, out);
        left.sadd(-1.0, 1.0, in);
        nodes.read(left, std::span(fine_values));
        from_linear.restrict_to(std::span<const double>(fine_values), coarse_values);
        clear_constrained(std::span(coarse_values), is_vertex_free);
        vertices.write(std::span<const double>(coarse_values), residual);
        coarse->vmult(correction, residual);
        vertices.read(correction, std::span(coarse_values));
        std::ranges::fill(fine_values, 0.0);
        from_linear.add_prolonged(std::span<const double>(coarse_values), fine_values);
        clear_constrained(std::span(fine_values), is_free);
        nodes.write(std::span<const double>(fine_values), left);
        out += left;
    }

    const ElasticSystem &quadratic;
    const NodeExchange &nodes;
    RigidModes rigid;
    const std::vector<bool> &is_free;
    ElasticSystem linear; ///< its stiffness is P^T K P
    NodeExchange vertices;
    Prolongation from_linear;
    std::vector<bool> is_vertex_free;
    SymmetricBlocks<float> rounded_stiffness;
    std::optional<Smoothed> smoothed;
    std::optional<Chebyshev> smoother;
    std::optional<DistributedMultigrid> coarse;
    mutable NodeExchange::Vector residual, correction; ///< of linear elements
    mutable std::vector<double> fine_values, coarse_values;
};

DistributedLevels::DistributedLevels(const Part &part, const ElasticSystem &quadratic, const NodeExchange &nodes,
                                     const RigidModes &rigid, const std::vector<bool> &is_free)
    : impl_(std::make_unique<Impl>(part, quadratic, nodes, rigid, is_free)) {}
DistributedLevels::~DistributedLevels() = default;

void DistributedLevels::set_up(const SymmetricBlocks<double> &stiffness) {
    auto &impl = *impl_;
    impl.coarse.reset();
    impl.smoother.reset();
    impl.smoothed.reset();
    impl.rounded_stiffness = rounded(stiffness);
    impl.smoothed.emplace(impl.rounded_stiffness, impl.nodes, impl.is_free);
    Chebyshev::AdditionalData settings;
    settings.degree = smoother_degree;
    settings.smoothing_range = smoothing_range;
    settings.eig_cg_n_iterations = eigenvalue_iterations;
    settings.preconditioner = std::make_shared<BlockJacobi>(stiffness, impl.nodes, impl.is_free);
    impl.smoother.emplace();
    impl.smoother->initialize(*impl.smoothed, settings);
    impl.linear.stiffness = galerkin(impl.from_linear, stiffness, impl.linear.stiffness.rows);
    impl.coarse.emplace(impl.linear.stiffness, impl.vertices, impl.linear.points, impl.rigid, impl.is_vertex_free);
}

void DistributedLevels::vmult(Vector &out, const Vector &in) const {
    impl_->smoother->vmult(out, in);
    impl_->correct(out, in);
    impl_->smoother->step(out, in);
}

} // namespace livermark::fem_reference
