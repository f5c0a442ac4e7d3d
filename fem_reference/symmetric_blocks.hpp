#pragma once

#include <span>
#include <vector>

#include "fem_reference/columns.hpp"
#include "fem_reference/elastic_system.hpp"
#include "fem_reference/node_order.hpp"
#include "fem_reference/rows_of_blocks.hpp"

namespace livermark::fem_reference {

/// A stiffness matrix kept for products alone, which take as long as its bytes take to come: of the 3 x 3 blocks those
/// on and below the diagonal, one column number each, which is 40 % of what compressed rows hold. Neighbours should be
/// near each other, see NodeOrder.
class SymmetricBlocks {
  public:
    /// @param matrix  of 3 x 3 blocks, as ElasticSystem has it
    explicit SymmetricBlocks(const SymmetricMatrix &matrix);

    /// out_c = K x_c
    /// @param x, out  shape (3 n, lanes), see columns.hpp; not the same
    void multiply(std::span<const double> x, std::span<double> out) const;

  private:
    LowerRows rows_;
    std::vector<Block<double>> block_;    ///< (blocks)
    std::vector<Block<double>> diagonal_; ///< (n)
};

} // namespace livermark::fem_reference
