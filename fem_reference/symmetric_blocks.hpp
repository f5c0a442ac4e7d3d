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
/// @tparam T  double, or float where products may be rough: that is half of the bytes
template <class T> class SymmetricBlocks {
  public:
    /// @param matrix  of 3 x 3 blocks, as ElasticSystem has it
    explicit SymmetricBlocks(const SymmetricMatrix &matrix);

    /// out_c = K x_c
    /// @param x, out  shape (3 n, lanes), see columns.hpp; not the same
    void multiply(std::span<const T> x, std::span<T> out) const;

  private:
    LowerRows rows_;
    std::vector<Block<T>> block_;    ///< (blocks)
    std::vector<Block<T>> diagonal_; ///< (n)
};

} // namespace livermark::fem_reference
