#include "fem_reference/symmetric_blocks.hpp"

#include <algorithm>

namespace livermark::fem_reference {

namespace {

/// A row of blocks: what it makes of the vectors before it, and what these take from it.
/// @tparam first, some  the lanes that are looked at: more would not fit the registers
template <int lanes, int first, int some>
[[gnu::always_inline]] inline void row_product(const LowerRows &rows, const Block<double> *below,
                                               const Block<double> &diagonal, std::size_t at, const double *in,
                                               double *sum) {
    constexpr std::size_t width = 3 * lanes;
    using Vector = Triple<double, some, lanes>;
    const Vector here(in + width * at + first);
    Vector row;
    add_product(diagonal, here, row);
    for (int k = rows.row_start[at]; k < rows.row_start[at + 1]; ++k) {
        ask_ahead(below + k, 1);
        const auto other = width * rows.column[k] + first;
        add_product(below[k], Vector(in + other), row);
        Vector there(sum + other);
        add_transposed(below[k], here, there);
        there.put(sum + other);
    }
    row.put(sum + width * at + first); // what lies behind comes later
}

template <int lanes>
[[gnu::always_inline]] inline void product(const LowerRows &rows, const std::vector<Block<double>> &below,
                                           const std::vector<Block<double>> &diagonal, std::span<const double> x,
                                           std::span<double> out) {
    for (std::size_t at = 0; at < rows.num_nodes(); ++at) {
        row_product<lanes, 0, std::min(lanes, 4)>(rows, below.data(), diagonal[at], at, x.data(), out.data());
        if constexpr (lanes > 4)
            row_product<lanes, 4, 4>(rows, below.data(), diagonal[at], at, x.data(), out.data());
    }
}

} // namespace

SymmetricBlocks::SymmetricBlocks(const SymmetricMatrix &matrix) : rows_(lower_rows(matrix)) {
    block_.reserve(rows_.column.size());
    diagonal_.reserve(rows_.num_nodes());
    for_each_lower_block(matrix, [&](int node, int other, const double *first, int stride) {
        auto &block = other == node ? diagonal_.emplace_back() : block_.emplace_back();
        for (int i = 0; i < 3; ++i)
            std::copy_n(first + i * stride, 3, &block[3 * i]);
    });
}

LIVERMARK_WIDE_CLONES
void SymmetricBlocks::multiply(std::span<const double> x, std::span<double> out) const {
    switch (x.size() / (3 * rows_.num_nodes())) { // a lambda would be compiled for one processor
    case 1:
        return product<1>(rows_, block_, diagonal_, x, out);
    case 4:
        return product<4>(rows_, block_, diagonal_, x, out);
    default:
        return product<most_lanes>(rows_, block_, diagonal_, x, out);
    }
}

} // namespace livermark::fem_reference
