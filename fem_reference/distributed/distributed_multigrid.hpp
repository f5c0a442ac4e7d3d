#pragma once

#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>

#include <span>
#include <vector>

#include "fem_reference/distributed/node_exchange.hpp"
#include "fem_reference/solvers/multigrid/rigid_modes.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"

namespace livermark::fem_reference {

/// Smoothed aggregation multigrid (Trilinos ML) over all ranks, of a stiffness that each rank has on its part. What is
/// constrained is zero in whatever comes out, if it is in what comes in.
class DistributedMultigrid {
  public:
    using Vector = NodeExchange::Vector;

    /// Collective.
    /// @param stiffness  of the part, complete in the rows of nodes that this rank owns
    /// @param nodes      of the part, three components each
    /// @param points     (n) of the part [m]
    /// @param rigid      of the whole body
    /// @param is_free    shape (3 n)
    DistributedMultigrid(const SymmetricBlocks<double> &stiffness, const NodeExchange &nodes,
                         std::span<const core::Vector3> points, const RigidModes &rigid,
                         const std::vector<bool> &is_free);

    /// Collective. out = an approximate K^-1 in
    void vmult(Vector &out, const Vector &in) const { levels_.vmult(out, in); }

  private:
    dealii::TrilinosWrappers::SparseMatrix matrix_;
    dealii::TrilinosWrappers::PreconditionAMG levels_;
};

} // namespace livermark::fem_reference
