#pragma once

#include <span>
#include <vector>

#include "fem_reference/elastic_system.hpp"
#include "fem_reference/node_order.hpp"
#include "fem_reference/rows_of_blocks.hpp"

namespace livermark::fem_reference {

/// Gauss-Seidel sweeps over the nodes of a system, three components at a time, in an order that keeps neighbours near
/// each other. A smoother lives from the memory that it does not move: it is in single precision, and of the blocks
/// only those below the diagonal are kept. What a row of them takes from the nodes before gives, transposed, what
/// these nodes take from it, so each sweep reads them once.
class BlockGaussSeidel {
  public:
    /// @param matrix   of 3 x 3 blocks, as ElasticSystem has it
    /// @param is_free  shape (3 n); the rows and columns of the others are those of the unit matrix
    BlockGaussSeidel(const SymmetricMatrix &matrix, const std::vector<bool> &is_free);

    /// One sweep from the first node to the last, from zero.
    /// @param right_hand_side  shape (3 n), zero where not free
    /// @param u                shape (3 n), what it was does not matter
    /// @param residual         shape (3 n) right_hand_side - K u
    void sweep_forward_from_zero(std::span<const double> right_hand_side, std::span<double> u,
                                 std::span<double> residual);

    /// One sweep from the last node to the first: the adjoint of the forward one.
    /// @param u  shape (3 n), improved
    void sweep_backward(std::span<const double> right_hand_side, std::span<double> u);

  private:
    LowerRows rows_;
    std::vector<Block<float>> block_;            ///< (blocks + 1) and a last one that may be read
    std::vector<Block<float>> inverse_diagonal_; ///< (n + 1) likewise
    std::vector<Padded<float>> now_;             ///< (n) what a sweep works on
    std::vector<Padded<float>> taken_;           ///< (n) K u of the rows behind
};

} // namespace livermark::fem_reference
