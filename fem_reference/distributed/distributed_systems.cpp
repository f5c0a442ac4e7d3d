#include "fem_reference/distributed/distributed_systems.hpp"

#include <deal.II/base/mpi.h>
#include <deal.II/base/subscriptor.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/la_parallel_block_vector.h>
#include <deal.II/lac/precondition.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>

#include <Eigen/LU>
#include <Teuchos_ParameterList.hpp>
#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::fem_reference {

namespace {

using Number = dealii::types::global_dof_index;

Number unknown(const NodeExchange &nodes, int node, int component) {
    return static_cast<Number>(3 * nodes.numbers()[node] + component);
}

/// Entries of the rows of this rank.
dealii::DynamicSparsityPattern pattern(const SymmetricMatrix &blocks, const NodeExchange &nodes) {
    const auto &own = nodes.partitioner()->locally_owned_range();
    dealii::DynamicSparsityPattern result(own.size(), own.size(), own);
    std::vector<Number> columns;
    for (const int node : nodes.owned()) {
        columns.clear();
        for (int k = blocks.row_start[node]; k < blocks.row_start[node + 1]; ++k)
            for (int j = 0; j < 3; ++j)
                columns.push_back(unknown(nodes, blocks.column[k], j));
        for (int i = 0; i < 3; ++i)
            result.add_entries(unknown(nodes, node, i), columns.begin(), columns.end());
    }
    return result;
}

/// Calls action(a, b, block, is_transposed) for the blocks on and below the diagonal of which this rank owns row a, and
/// for those above.
template <class Action>
void for_each_owned_block(const SymmetricBlocks<double> &matrix, const NodeExchange &nodes, const Action &action) {
    for (int a = 0; a < static_cast<int>(matrix.diagonal.size()); ++a) {
        if (nodes.owns(a))
            action(a, a, matrix.diagonal[a], false);
        for (int k = matrix.rows.row_start[a]; k < matrix.rows.row_start[a + 1]; ++k) {
            const int b = matrix.rows.column[k];
            if (nodes.owns(a))
                action(a, b, matrix.below[k], false);
            if (nodes.owns(b))
                action(b, a, matrix.below[k], true);
        }
    }
}

dealii::TrilinosWrappers::SparseMatrix global_matrix(const SymmetricBlocks<double> &stiffness,
                                                     const NodeExchange &nodes, const std::vector<bool> &is_free) {
    dealii::TrilinosWrappers::SparseMatrix result;
    result.reinit(nodes.partitioner()->locally_owned_range(), pattern(zero_of_blocks(stiffness.rows), nodes),
                  MPI_COMM_WORLD);
    for_each_owned_block(stiffness, nodes, [&](int a, int b, const Block<double> &block, bool is_transposed) {
        for (int i = 0; i < 3; ++i) {
            std::array<Number, 3> columns{};
            std::array<double, 3> values{};
            for (int j = 0; j < 3; ++j) {
                const bool counts = (a == b && i == j) || (is_free[3 * a + i] && is_free[3 * b + j]);
                columns[j] = unknown(nodes, b, j);
                values[j] = counts ? block[is_transposed ? 3 * j + i : 3 * i + j] : 0.0;
            }
            result.set(unknown(nodes, a, i), columns.size(), columns.data(), values.data(), false);
        }
    });
    result.compress(dealii::VectorOperation::insert);
    return result;
}

/// At the unknowns of this rank, zero where constrained.
/// @return shape (6, owned unknowns)
std::vector<double> modes_of_rank(const NodeExchange &nodes, std::span<const core::Vector3> points,
                                  const RigidModes &rigid, const std::vector<bool> &is_free) {
    const auto size = 3 * nodes.owned().size();
    std::vector<double> modes(RigidModes::count * size, 0.0);
    for (std::size_t k = 0; k < nodes.owned().size(); ++k) {
        const int node = nodes.owned()[k];
        const auto at_node = rigid.at(points[node]);
        for (int i = 0; i < 3; ++i)
            for (int m = 0; m < RigidModes::count; ++m)
                modes[m * size + 3 * k + i] = is_free[3 * node + i] ? at_node(i, m) : 0.0;
    }
    return modes;
}

} // namespace

DistributedMultigrid::DistributedMultigrid(const SymmetricBlocks<double> &stiffness, const NodeExchange &nodes,
                                           std::span<const core::Vector3> points, const RigidModes &rigid,
                                           const std::vector<bool> &is_free)
    : matrix_(global_matrix(stiffness, nodes, is_free)) {
    auto modes = modes_of_rank(nodes, points, rigid, is_free);
    auto settings = multigrid_settings(modes);
    levels_.initialize(matrix_, settings);
}

/// The inverses of the diagonal blocks, of what is free: what Chebyshev's polynomials smooth with.
class BlockJacobi : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    BlockJacobi(const SymmetricBlocks<double> &stiffness, const NodeExchange &nodes, const std::vector<bool> &is_free) {
        for (const int node : nodes.owned()) {
            Eigen::Matrix3d block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(stiffness.diagonal[node].data());
            for (int i = 0; i < 3; ++i)
                if (!is_free[3 * node + i]) {
                    block.row(i).setZero();
                    block.col(i).setZero();
                    block(i, i) = 1.0;
                }
            Eigen::Matrix3d inverse = block.inverse();
            for (int i = 0; i < 3; ++i)
                if (!is_free[3 * node + i])
                    inverse(i, i) = 0.0;
            inverse_.push_back(inverse);
        }
    }

    void vmult(Vector &out, const Vector &in) const {
        for (std::size_t k = 0; k < inverse_.size(); ++k)
            Eigen::Vector3d::Map(out.begin() + 3 * k) = inverse_[k] * Eigen::Vector3d::Map(in.begin() + 3 * k);
    }

  private:
    std::vector<Eigen::Matrix3d> inverse_; ///< (owned nodes)
};

using Smoothed = DistributedStiffness<float>;
using Chebyshev = dealii::PreconditionChebyshev<Smoothed, NodeExchange::Vector, BlockJacobi>;

/// Products before and behind the correction, and over which part of the spectrum they act: beyond that linear elements
/// see what is left.
constexpr unsigned int smoother_degree = 3;
constexpr double smoothing_range = 12.0;
constexpr unsigned int eigenvalue_iterations = 12;

/// An approximate inverse of the stiffness of quadratic elements over all ranks: linear elements of the same
/// tetrahedra with a smoothed aggregation multigrid of their own below, and polynomials of Chebyshev over the diagonal
/// blocks before and behind, which are the same however the body is cut. Where the material is nearly incompressible
/// the stiffness has to be the one without lambda, see without_pressure().
/// (M. Adams, M. Brezina, J. Hu, R. Tuminaro 2003, Parallel multigrid smoothing, J. Comput. Phys. 188(2))
struct DistributedLevels {
    /// Collective. System, nodes and is_free are kept alive by the caller.
    /// @param quadratic_system  assembled on the part
    /// @param exchange          of its nodes, three components each
    /// @param body_modes        of the whole body
    /// @param free              shape (3 n)
    DistributedLevels(const Part &part, const ElasticSystem &quadratic_system, const NodeExchange &exchange,
                      const RigidModes &body_modes, const std::vector<bool> &free)
        : quadratic(quadratic_system), nodes(exchange), rigid(body_modes), is_free(free),
          linear(assemble(without_pressure(*part.problem.body), 1)), vertices(nodes_of(part, linear), 3),
          from_linear(prolongation(linear, quadratic)), is_vertex_free(3 * linear.points.size()),
          residual(vertices.vector()), correction(vertices.vector()) {
        for (std::size_t dof = 0; dof < is_vertex_free.size(); ++dof)
            is_vertex_free[dof] = is_free[3 * from_linear.fine_node[dof / 3] + dof % 3];
        fine_values.resize(3 * quadratic.points.size());
        coarse_values.resize(is_vertex_free.size());
    }

    /// Collective.
    void set_up(const SymmetricBlocks<double> &stiffness) {
        coarse.reset();
        smoother.reset();
        smoothed.reset();
        rounded_stiffness = rounded(stiffness);
        smoothed.emplace(rounded_stiffness, nodes, is_free);
        Chebyshev::AdditionalData settings;
        settings.degree = smoother_degree;
        settings.smoothing_range = smoothing_range;
        settings.eig_cg_n_iterations = eigenvalue_iterations;
        settings.preconditioner = std::make_shared<BlockJacobi>(stiffness, nodes, is_free);
        smoother.emplace();
        smoother->initialize(*smoothed, settings);
        linear.stiffness = galerkin(from_linear, stiffness, linear.stiffness.rows);
        coarse.emplace(linear.stiffness, vertices, linear.points, rigid, is_vertex_free);
    }

    /// Collective, after set_up().
    void vmult(NodeExchange::Vector &out, const NodeExchange::Vector &in) const {
        smoother->vmult(out, in);
        correct(out, in);
        smoother->step(out, in);
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

/// The mass of the pressure that each rank has on its part.
class DistributedMass : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    /// Both are kept alive by the caller.
    /// @param matrix  of the part, complete in the rows that this rank owns
    DistributedMass(const SymmetricMatrix &matrix, const NodeExchange &pressures)
        : matrix_(matrix), pressures_(pressures), from_(matrix.value.empty() ? 0 : matrix.num_rows()),
          to_(from_.size()) {}

    void vmult(Vector &out, const Vector &in) const {
        pressures_.read(in, std::span(from_));
        if (!from_.empty())
            multiply(matrix_, from_, to_, 1);
        pressures_.write(std::span<const double>(to_), out);
    }

  private:
    const SymmetricMatrix &matrix_;
    const NodeExchange &pressures_;
    mutable std::vector<double> from_, to_;
};

/// Over its diagonal.
class InverseDiagonal : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    InverseDiagonal(const SymmetricMatrix &matrix, const NodeExchange &pressures) {
        for (const int row : pressures.owned())
            for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
                if (matrix.column[k] == row)
                    inverse_.push_back(1.0 / matrix.value[k]);
    }
    void vmult(Vector &out, const Vector &in) const {
        std::ranges::transform(inverse_, std::span(in.begin(), inverse_.size()), out.begin(), std::multiplies<>());
    }

  private:
    std::vector<double> inverse_; ///< (owned pressures)
};

using BlockVector = dealii::LinearAlgebra::distributed::BlockVector<double>;

/// Vectors of a Krylov space: more than ever were needed, so that it need not begin anew.
constexpr unsigned int largest_space_on_ranks = 80;
/// Reduction that one round of iterations may reach: the smoothers are in single precision, and so what a round
/// believes to be left differs from what is left.
constexpr double furthest_round_on_ranks = 1e-5;
/// A round that ends further than it was told to begins another one.
constexpr double reserve_on_ranks = 0.5;

using ChebyshevOfMass = dealii::PreconditionChebyshev<DistributedMass, NodeExchange::Vector, InverseDiagonal>;

/// The mass of linear functions on a tetrahedron has these over its diagonal.
constexpr double largest_eigenvalue = 2.5, smallest_eigenvalue = 0.5;
/// Leaves less than a thousandth: more would not save iterations.
constexpr unsigned int mass_degree = 8;

void MatricesOfPart::apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
                           std::span<double> imbalance) const {
    stiffness.multiply(u, force);
    if (!p.empty()) {
        multiply(compliance, p, imbalance);
        divergence.add_products(u, p, force, imbalance, 1);
    }
    if (add_product)
        add_product(u, force);
}

struct DistributedSaddlePoint::Impl {
    Impl(const Part &part, const ElasticSystem &system, const PressureSystem &pressure, const NodeExchange &exchange,
         const RigidModes &rigid, double scale_of_pressure, std::vector<bool> free)
        : nodes(exchange), pressures(pressures_of(part, pressure), 1), is_free(std::move(free)),
          levels(part, system, nodes, rigid, is_free), mass(pressure.norm, pressures), scale(scale_of_pressure),
          num_pressures(pressure.num_pressures()) {
        ChebyshevOfMass::AdditionalData settings;
        settings.degree = mass_degree;
        settings.max_eigenvalue = largest_eigenvalue;
        settings.smoothing_range = largest_eigenvalue / smallest_eigenvalue;
        settings.eig_cg_n_iterations = 0; // they are known
        settings.preconditioner = std::make_shared<InverseDiagonal>(pressure.norm, pressures);
        inverse_mass.initialize(mass, settings);
    }

    BlockVector vector() const {
        BlockVector result(2);
        result.block(0) = nodes.vector();
        result.block(1) = pressures.vector();
        result.collect_sizes();
        return result;
    }

    /// Products on the part, pressures in their scale.
    void apply(const MatricesOfPart &matrices, BlockVector &out, const BlockVector &in) const {
        nodes.read(in.block(0), std::span(u));
        pressures.read(in.block(1), std::span(p));
        for (double &value : p)
            value *= scale;
        matrices.apply(u, p, force, volume);
        write(force, volume, out);
    }

    void write(std::vector<double> &force_on_part, std::vector<double> &volume_on_part, BlockVector &out) const {
        clear_constrained(std::span(force_on_part), is_free);
        for (double &value : volume_on_part)
            value *= scale;
        nodes.write(std::span<const double>(force_on_part), out.block(0));
        pressures.write(std::span<const double>(volume_on_part), out.block(1));
    }

    /// u = K^-1 f, p = S^-1 (D u - g)
    void precondition(const MatricesOfPart &matrices, BlockVector &out, const BlockVector &in) const {
        levels.vmult(out.block(0), in.block(0));
        if (pressures.num_entries_of_all_ranks() == 0)
            return;
        nodes.read(out.block(0), std::span(u));
        std::ranges::fill(p, 0.0);
        if (num_pressures > 0)
            matrices.divergence.subtract_product(u, p, volume, 1);
        auto imbalance = pressures.vector();
        pressures.write(std::span<const double>(volume), imbalance);
        imbalance.add(-1.0 / scale, in.block(1));
        inverse_mass.vmult(out.block(1), imbalance);
        out.block(1) *= 1.0 / scale;
    }

    const NodeExchange &nodes;
    NodeExchange pressures;
    std::vector<bool> is_free;
    DistributedLevels levels;
    DistributedMass mass;
    ChebyshevOfMass inverse_mass;
    double scale;
    int num_pressures;
    mutable std::vector<double> u = std::vector<double>(is_free.size()), force = u; ///< (3 n)
    mutable std::vector<double> p = std::vector<double>(num_pressures), volume = p; ///< (m)
};

DistributedSaddlePoint::DistributedSaddlePoint(const Part &part, const ElasticSystem &system,
                                               const PressureSystem &pressure, const NodeExchange &nodes,
                                               const RigidModes &rigid, double scale, std::vector<bool> is_free)
    : impl_(std::make_unique<Impl>(part, system, pressure, nodes, rigid, scale, std::move(is_free))) {}
DistributedSaddlePoint::~DistributedSaddlePoint() = default;

const NodeExchange &DistributedSaddlePoint::pressures() const {
    return impl_->pressures;
}

void DistributedSaddlePoint::set_up(const SymmetricBlocks<double> &stiffness) {
    impl_->levels.set_up(stiffness);
}

DistributedSaddlePoint::Ending DistributedSaddlePoint::solve(const MatricesOfPart &matrices, const MixedField &right,
                                                             double tolerance, int max_iterations,
                                                             MixedField &found) const {
    const auto &impl = *impl_;
    const Operator matrix{[&](BlockVector &out, const BlockVector &in) { impl.apply(matrices, out, in); }};
    const Operator preconditioner{
        [&](BlockVector &out, const BlockVector &in) { impl.precondition(matrices, out, in); }};
    auto load = impl.vector(), x = impl.vector();
    impl.force = right.u;
    impl.volume = right.p;
    impl.write(impl.force, impl.volume, load);

    Ending ending{.converged = true};
    auto left = load, correction = x;
    double first = 0.0;
    using Solver = dealii::SolverGMRES<BlockVector>;
    for (double reached = 1.0; ending.converged && reached > tolerance;) {
        dealii::ReductionControl control(max_iterations - ending.iterations, std::numeric_limits<double>::min(),
                                         std::max(reserve_on_ranks * tolerance / reached, furthest_round_on_ranks));
        correction = 0.0;
        try {
            Solver(control, Solver::AdditionalData(largest_space_on_ranks))
                .solve(matrix, correction, left, preconditioner);
        } catch (const dealii::SolverControl::NoConvergence &) {
            ending.converged = false;
        }
        ending.iterations += static_cast<int>(control.last_step());
        x += correction;
        matrix.vmult(left, x);
        left.sadd(-1.0, 1.0, load);
        preconditioner.vmult(correction, left);
        if (first == 0.0)
            first = control.initial_value();
        const double before = std::exchange(reached, first > 0.0 ? correction.l2_norm() / first : 0.0);
        ending.relative_residual = reached;
        ending.converged = ending.converged && reached < reserve_on_ranks * before;
    }
    found.u.resize(impl.is_free.size());
    found.p.resize(impl.num_pressures);
    impl.nodes.read(x.block(0), std::span(found.u));
    impl.pressures.read(x.block(1), std::span(found.p));
    for (double &pressure : found.p)
        pressure *= impl.scale;
    return ending;
}

} // namespace livermark::fem_reference
