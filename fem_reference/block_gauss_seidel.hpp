#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fem_reference/elastic_system.hpp"

namespace livermark::fem_reference {

/// Gauss-Seidel sweeps over the nodes of a system, three components at a time. Kept in single precision: a smoother
/// lives from the memory that it does not move. Vectors of three are padded to four, so that a processor takes them
/// at once; blocks are not: a fourth lane gets what comes next in memory, and nobody looks at it.
class BlockGaussSeidel {
  public:
    /// @param matrix   of 3 x 3 blocks, as ElasticSystem has it
    /// @param is_free  shape (3 n); the rows and columns of the others are those of the unit matrix
    BlockGaussSeidel(const SymmetricMatrix &matrix, const std::vector<bool> &is_free);

    /// One sweep from the first node to the last, from zero.
    /// @param right_hand_side  shape (3 n), zero where not free
    /// @param u                shape (3 n), what it was does not matter
    void sweep_forward_from_zero(std::span<const double> right_hand_side, std::span<double> u);

    /// right_hand_side - K u after sweep_forward_from_zero: of the rows only what lies behind the diagonal is left.
    void residual_after_forward(std::span<const double> u, std::span<double> residual);

    /// One sweep from the last node to the first: the adjoint of the forward one.
    /// @param u  shape (3 n), improved
    void sweep_backward(std::span<const double> right_hand_side, std::span<double> u);

  private:
    using PaddedBlock = Eigen::Matrix<float, 4, 3>; ///< the last row is zero
    using Padded = Eigen::Vector4f;                 ///< the last component does not count

    /// sum - (blocks from begin to end) now_
    Padded less_blocks(Padded sum, int begin, int end) const;
    /// The same, the last block first: a sweep that goes down in memory has to do so in each row as well, or nothing is
    /// fetched ahead.
    Padded less_blocks_from_the_last(Padded sum, int begin, int end) const;
    Padded less_block(const Padded &sum, int k) const;
    void load(std::span<const double> u);
    void put(int node, const Padded &value, std::span<double> u);

    std::vector<int> row_start_;                ///< (n + 1)
    std::vector<int> diagonal_;                 ///< (n) place of the diagonal block in column_
    std::vector<int> column_;                   ///< (blocks) node
    std::vector<float> block_;                  ///< (9 blocks + 1) by columns, and a last one that may be read
    std::vector<PaddedBlock> inverse_diagonal_; ///< (n)
    std::vector<Padded> now_;                   ///< (n) what a sweep works on
};

} // namespace livermark::fem_reference
