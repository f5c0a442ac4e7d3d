#pragma once

#include <memory>
#include <vector>

#include "fem_reference/distributed/node_exchange.hpp"
#include "fem_reference/solvers/multigrid/rigid_modes.hpp"

namespace livermark::fem_reference {

/// An approximate inverse of the stiffness of quadratic elements over all ranks: linear elements of the same
/// tetrahedra with a smoothed aggregation multigrid of their own below, and polynomials of Chebyshev over the diagonal
/// blocks before and behind, which are the same however the body is cut. Where the material is nearly incompressible
/// the stiffness has to be the one without lambda, see without_pressure().
/// (M. Adams, M. Brezina, J. Hu, R. Tuminaro 2003, Parallel multigrid smoothing, J. Comput. Phys. 188(2))
class DistributedLevels {
  public:
    using Vector = NodeExchange::Vector;

    /// Collective. Part, system, nodes and is_free are kept alive by the caller.
    /// @param quadratic  assembled on the part
    /// @param nodes      of it, three components each
    /// @param rigid      of the whole body
    /// @param is_free    shape (3 n)
    DistributedLevels(const Part &part, const ElasticSystem &quadratic, const NodeExchange &nodes,
                      const RigidModes &rigid, const std::vector<bool> &is_free);
    ~DistributedLevels();

    /// Collective.
    void set_up(const SymmetricBlocks<double> &stiffness);

    /// Collective, after set_up().
    void vmult(Vector &out, const Vector &in) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
