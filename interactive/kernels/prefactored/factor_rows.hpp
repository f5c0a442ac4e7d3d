#pragma once

#include <cstdint>
#include <vector>

#include "interactive/kernels/node_rows.hpp"
#include "support/factors/sparse_cholesky.hpp"

namespace livermark::interactive::kernels {

/// The columns of a supernode of L, the triangle L11 on top and the rectangle L21 below it, as the panel
///     B = [L11^-1; -L21 L11^-1],
/// by which both sweeps are products that wait for nothing: forwards (x1, x2) <- B x1 + (0, x2), backwards
/// x1 <- B^T (x1, x2).
struct Panel {
    std::size_t first_column, num_columns; ///< of L
    std::size_t first_block, num_blocks;   ///< of 16 rows, the last one filled up
    std::size_t first_value;

    /// What fills up has no other columns to share a load with.
    static constexpr std::size_t columns_at_once = 4;
    std::size_t stored_columns() const {
        return (num_columns + columns_at_once - 1) / columns_at_once * columns_at_once;
    }
    /// Rows of the triangle have no more than these.
    std::size_t columns_of_block(std::size_t block) const {
        return std::min(stored_columns(), (block + 1) * slice_size);
    }
};

/// A factor of P A P^T = L L^T in single precision for vector units, which solves for three right-hand sides at once:
/// x, y and z stand side by side in a row of four, and an entry is read once for all of them.
struct FactorRows {
    std::size_t num_unknowns = 0;
    std::vector<std::int32_t> place; ///< (n) four times the place of each unknown in the order of L
    std::vector<Panel> panels;
    Aligned<std::int32_t> row;   ///< 16 for each block: four times the place; the one behind all others fills up
    Aligned<float> values;       ///< block after block, and in each column after column
    Aligned<float> x;            ///< (n + 1) rows of four: right-hand sides, and the solutions; zero behind all others
    Aligned<float> own, fetched; ///< space for the columns and the rows of a panel

    std::size_t bytes() const { return bytes_of(row, values, x); }
};

FactorRows factor_rows(const support::SupernodalFactor &factor);

} // namespace livermark::interactive::kernels
