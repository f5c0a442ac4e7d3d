#pragma once

#include <span>
#include <vector>

#include "fem_reference/solvers/multivector.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"

namespace livermark::fem_reference {

/// Gauss-Seidel sweeps over the nodes of a system, three components at a time. A smoother lives from the memory that it
/// does not move: it is in single precision, and of the blocks only those below the diagonal are kept. What a row of
/// them takes from the nodes before gives, transposed, what these nodes take from it, so each sweep reads them once.
/// Neighbours should be near each other, see NodeOrder.
class BlockGaussSeidel {
  public:
    /// @param matrix  kept alive and unchanged by the caller
    explicit BlockGaussSeidel(const SymmetricBlocks<float> &matrix);

    /// From now on sweeps are over the free unknowns of each column; the others are zero in whatever comes out.
    void set_up(const FreeUnknowns &free);

    /// One sweep from the first node to the last, from zero.
    /// @param right_hand_side  shape (3 n, lanes)
    /// @param u                shape (3 n, lanes), what it was does not matter
    /// @param residual         shape (3 n, lanes) right_hand_side - K u
    void sweep_forward_from_zero(std::span<const float> right_hand_side, std::span<float> u, std::span<float> residual);

    /// One sweep from the last node to the first: the adjoint of the forward one.
    /// @param u  shape (3 n, lanes), zero where not free; improved
    void sweep_backward(std::span<const float> right_hand_side, std::span<float> u);

  private:
    template <int lanes> class Sweep;
    template <int lanes>
    void forward(std::span<const float> right_hand_side, std::span<float> u, std::span<float> residual);
    template <int lanes> void backward(std::span<const float> right_hand_side, std::span<float> u);

    const SymmetricBlocks<float> &matrix_;
    std::vector<Block<float>> inverse_diagonal_; ///< (n) where all is free
    int lanes_ = 0;
    std::vector<int> constrained_;           ///< (n) index into the next two, -1 where all columns are free
    std::vector<float> constrained_inverse_; ///< (9, lanes) each: of the free rows and columns, otherwise zero
    std::vector<float> is_free_;             ///< (3, lanes) each: 1 or 0
    std::vector<float> taken_;               ///< (n, 3, lanes) K u of the rows behind
};

} // namespace livermark::fem_reference
