#include "fem_reference/distributed/distributed_multigrid.hpp"

#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include "fem_reference/solvers/multigrid/multigrid_settings.hpp"

namespace livermark::fem_reference {

namespace {

using Number = dealii::types::global_dof_index;

Number unknown(const NodeExchange &nodes, int node, int component) {
    return static_cast<Number>(3 * nodes.numbers()[node] + component);
}

/// Where the rows of this rank have entries.
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

} // namespace livermark::fem_reference
