#include "fem_reference/symmetric_blocks.hpp"

#include <algorithm>

namespace livermark::fem_reference {

namespace {

/// A row of blocks: what it makes of the vectors before it, and what these take from it.
/// @tparam first, some  the lanes that are looked at: more would not fit the registers
template <int lanes, int first, int some, class T>
[[gnu::always_inline]] inline void row_product(const LowerRows &rows, const Block<T> *below, const Block<T> &diagonal,
                                               std::size_t at, const T *in, T *sum) {
    constexpr std::size_t width = 3 * lanes;
    using Vector = Triple<T, some, lanes>;
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

template <int lanes, class T>
[[gnu::always_inline]] inline void product(const LowerRows &rows, const std::vector<Block<T>> &below,
                                           const std::vector<Block<T>> &diagonal, std::span<const T> x,
                                           std::span<T> out) {
    constexpr int some = std::min<int>(lanes, 32 / sizeof(T));
    for (std::size_t at = 0; at < rows.num_nodes(); ++at) {
        row_product<lanes, 0, some>(rows, below.data(), diagonal[at], at, x.data(), out.data());
        if constexpr (lanes > some)
            row_product<lanes, some, lanes - some>(rows, below.data(), diagonal[at], at, x.data(), out.data());
    }
}

template <class T>
[[gnu::always_inline]] inline void product_of_lanes(const LowerRows &rows, const std::vector<Block<T>> &below,
                                                    const std::vector<Block<T>> &diagonal, std::span<const T> x,
                                                    std::span<T> out) {
    switch (x.size() / (3 * rows.num_nodes())) { // a lambda would be compiled for one processor
    case 1:
        return product<1>(rows, below, diagonal, x, out);
    case 4:
        return product<4>(rows, below, diagonal, x, out);
    default:
        return product<most_lanes>(rows, below, diagonal, x, out);
    }
}

} // namespace

template <class T> SymmetricBlocks<T>::SymmetricBlocks(const SymmetricMatrix &matrix) : rows_(lower_rows(matrix)) {
    block_.reserve(rows_.column.size());
    diagonal_.reserve(rows_.num_nodes());
    for_each_lower_block(matrix, [&](int node, int other, const double *first, int stride) {
        auto &block = other == node ? diagonal_.emplace_back() : block_.emplace_back();
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                block[3 * i + j] = static_cast<T>(first[i * stride + j]);
    });
}

template <>
LIVERMARK_WIDE_CLONES void SymmetricBlocks<float>::multiply(std::span<const float> x, std::span<float> out) const {
    product_of_lanes(rows_, block_, diagonal_, x, out);
}
template <>
LIVERMARK_WIDE_CLONES void SymmetricBlocks<double>::multiply(std::span<const double> x, std::span<double> out) const {
    product_of_lanes(rows_, block_, diagonal_, x, out);
}

template class SymmetricBlocks<float>;
template class SymmetricBlocks<double>;

} // namespace livermark::fem_reference
