#pragma once

#include <array>
#include <span>
#include <vector>

#include "fem_reference/elastic_system.hpp"

namespace livermark::fem_reference {

/// A stiffness matrix kept for products alone, which take as long as its bytes take to come: of the 3 x 3 blocks those
/// on and above the diagonal, one column number each, which is 40 % of what compressed rows hold.
class SymmetricBlocks {
  public:
    /// @param matrix  of 3 x 3 blocks, as ElasticSystem has it
    explicit SymmetricBlocks(const SymmetricMatrix &matrix);

    /// out = K x
    /// @param x, out  shape (3 n), not the same
    void multiply(std::span<const double> x, std::span<double> out) const;

  private:
    using Block = std::array<double, 9>; ///< by rows

    std::vector<int> row_start_; ///< (n + 1)
    std::vector<int> column_;    ///< (blocks) node; the diagonal comes first in each row
    std::vector<Block> block_;   ///< (blocks)
};

} // namespace livermark::fem_reference
