#pragma once

#include <span>
#include <vector>

#include "fem_reference/solvers/rows_of_blocks.hpp"
#include "fem_reference/solvers/symmetric_matrix.hpp"

namespace livermark::fem_reference {

/// Where the 3 x 3 blocks below the diagonal stand.
struct LowerRows {
    std::vector<int> row_start; ///< (n + 1)
    std::vector<int> column;    ///< (blocks) ascending in each row
    std::size_t num_nodes() const { return row_start.size() - 1; }
};

/// The stiffness of n nodes: of its 3 x 3 blocks those on and below the diagonal, one column number each, which is 40 %
/// of what compressed rows hold. Products take as long as its bytes take to come. Neighbours should be near each other,
/// see NodeOrder.
/// @tparam T  double, or float where products may be rough: that is half of the bytes
template <class T> struct SymmetricBlocks {
    LowerRows rows;
    std::vector<Block<T>> below;    ///< (blocks) by rows
    std::vector<Block<T>> diagonal; ///< (n)

    int num_rows() const { return 3 * static_cast<int>(diagonal.size()); }

    /// out_c = K x_c
    /// @param x, out  shape (3 n, lanes), see multivector.hpp; not the same
    void multiply(std::span<const T> x, std::span<T> out) const;
};

template <> void SymmetricBlocks<float>::multiply(std::span<const float> x, std::span<float> out) const;
template <> void SymmetricBlocks<double>::multiply(std::span<const double> x, std::span<double> out) const;

SymmetricBlocks<float> rounded(const SymmetricBlocks<double> &matrix);

/// The same matrix as a factorisation wants it.
/// @return shape (3 n, 3 n)
SymmetricMatrix compressed_rows(const SymmetricBlocks<double> &matrix);

/// One entry for each block of the whole matrix, and all of them zero.
/// @return shape (n, n)
SymmetricMatrix zero_of_blocks(const LowerRows &rows);

} // namespace livermark::fem_reference
