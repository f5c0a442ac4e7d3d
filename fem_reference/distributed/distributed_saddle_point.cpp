#include "fem_reference/distributed/distributed_saddle_point.hpp"

#include <deal.II/lac/la_parallel_block_vector.h>
#include <deal.II/lac/precondition.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "fem_reference/distributed/distributed_mass.hpp"
#include "fem_reference/solvers/clear_constrained.hpp"

namespace livermark::fem_reference {

namespace {

using BlockVector = dealii::LinearAlgebra::distributed::BlockVector<double>;

/// Vectors of a Krylov space: more than ever were needed, so that it need not begin anew.
constexpr unsigned int largest_space = 80;
/// How far one round of iterations may go: the smoothers are in single precision, and so what a round believes to be
/// left differs from what is left.
constexpr double furthest_round = 1e-5;
/// A round that ends further than it was told to begins another one.
constexpr double reserve = 0.5;

using ChebyshevOfMass = dealii::PreconditionChebyshev<DistributedMass, NodeExchange::Vector, InverseDiagonal>;

/// Of the mass of linear functions on a tetrahedron over its diagonal.
constexpr double largest_eigenvalue = 2.5, smallest_eigenvalue = 0.5;
/// Leaves less than a thousandth: more would not save iterations.
constexpr unsigned int mass_degree = 8;

template <class Action> struct Operator {
    Action action;
    void vmult(BlockVector &out, const BlockVector &in) const { action(out, in); }
};
template <class Action> Operator(Action) -> Operator<Action>;

} // namespace

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
    Impl(const Part &part, const ElasticSystem &system, const PressureSystem &pressure, const NodeExchange &of_nodes,
         const RigidModes &rigid, double scale_of_pressure, std::vector<bool> free)
        : nodes(of_nodes), pressures(pressures_of(part, pressure), 1), is_free(std::move(free)),
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

    void write(std::vector<double> &of_u, std::vector<double> &of_p, BlockVector &out) const {
        clear_constrained(std::span(of_u), is_free);
        for (double &value : of_p)
            value *= scale;
        nodes.write(std::span<const double>(of_u), out.block(0));
        pressures.write(std::span<const double>(of_p), out.block(1));
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
                                         std::max(reserve * tolerance / reached, furthest_round));
        correction = 0.0;
        try {
            Solver(control, Solver::AdditionalData(largest_space)).solve(matrix, correction, left, preconditioner);
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
        ending.converged = ending.converged && reached < reserve * before;
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
