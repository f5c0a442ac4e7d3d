#pragma once

#include <deal.II/base/subscriptor.h>

#include <Eigen/LU>
#include <vector>

#include "fem_reference/distributed/node_exchange.hpp"
#include "fem_reference/solvers/clear_constrained.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"

namespace livermark::fem_reference {

/// A stiffness that each rank has on its part, as deal.II's solvers take it: K of what is free, zero elsewhere.
/// @tparam T  of the product
template <class T> class DistributedStiffness : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    /// All are kept alive by the caller.
    /// @param is_free  shape (3 n)
    DistributedStiffness(const SymmetricBlocks<T> &stiffness, const NodeExchange &nodes,
                         const std::vector<bool> &is_free)
        : stiffness_(stiffness), nodes_(nodes), is_free_(is_free), from_(is_free.size()), to_(is_free.size()) {}

    /// Collective.
    /// @param in  zero where not free
    void vmult(Vector &out, const Vector &in) const {
        nodes_.read(in, std::span(from_));
        stiffness_.multiply(from_, to_);
        clear_constrained(std::span(to_), is_free_);
        nodes_.write(std::span<const T>(to_), out);
    }

  private:
    const SymmetricBlocks<T> &stiffness_;
    const NodeExchange &nodes_;
    const std::vector<bool> &is_free_;
    mutable std::vector<T> from_, to_;
};

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

} // namespace livermark::fem_reference
