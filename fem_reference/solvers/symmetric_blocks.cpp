#include "fem_reference/solvers/symmetric_blocks.hpp"

#include <algorithm>
#include <numeric>

#include "fem_reference/solvers/multivector.hpp"

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

template <>
LIVERMARK_WIDE_CLONES void SymmetricBlocks<float>::multiply(std::span<const float> x, std::span<float> out) const {
    product_of_lanes(rows, below, diagonal, x, out);
}
template <>
LIVERMARK_WIDE_CLONES void SymmetricBlocks<double>::multiply(std::span<const double> x, std::span<double> out) const {
    product_of_lanes(rows, below, diagonal, x, out);
}

SymmetricBlocks<float> rounded(const SymmetricBlocks<double> &matrix) {
    SymmetricBlocks<float> result{matrix.rows, {}, {}};
    const auto round = [](const std::vector<Block<double>> &from, std::vector<Block<float>> &to) {
        to.reserve(from.size()); // and no zeros first: that would go through the memory twice
        for (const auto &block : from)
            std::ranges::transform(block, to.emplace_back().begin(), [](double x) { return static_cast<float>(x); });
    };
    round(matrix.below, result.below);
    round(matrix.diagonal, result.diagonal);
    return result;
}

SymmetricMatrix zero_of_blocks(const LowerRows &rows) {
    const auto num_nodes = static_cast<int>(rows.num_nodes());
    SymmetricMatrix matrix{std::vector<int>(num_nodes + 1, 0), {}, {}};
    for (int node = 0; node < num_nodes; ++node) {
        matrix.row_start[node + 1] += rows.row_start[node + 1] - rows.row_start[node] + 1;
        for (int k = rows.row_start[node]; k < rows.row_start[node + 1]; ++k)
            ++matrix.row_start[rows.column[k] + 1];
    }
    std::partial_sum(matrix.row_start.begin(), matrix.row_start.end(), matrix.row_start.begin());
    matrix.column.resize(matrix.row_start.back());
    // Row by row: what is left of the diagonal, the diagonal, and, from the rows behind, what is right of it.
    std::vector<int> next(matrix.row_start.begin(), matrix.row_start.end() - 1);
    for (int node = 0; node < num_nodes; ++node) {
        for (int k = rows.row_start[node]; k < rows.row_start[node + 1]; ++k) {
            matrix.column[next[node]++] = rows.column[k];
            matrix.column[next[rows.column[k]]++] = node;
        }
        matrix.column[next[node]++] = node;
    }
    matrix.value.assign(matrix.column.size(), 0.0);
    return matrix;
}

SymmetricMatrix compressed_rows(const SymmetricBlocks<double> &matrix) {
    const auto nodes = zero_of_blocks(matrix.rows);
    SymmetricMatrix result;
    result.row_start.push_back(0);
    result.column.reserve(9 * nodes.column.size());
    for (int node = 0; node < nodes.num_rows(); ++node)
        for (int i = 0; i < 3; ++i) {
            for (int k = nodes.row_start[node]; k < nodes.row_start[node + 1]; ++k)
                for (int j = 0; j < 3; ++j)
                    result.column.push_back(3 * nodes.column[k] + j);
            result.row_start.push_back(static_cast<int>(result.column.size()));
        }
    result.value.resize(result.column.size());
    const auto put = [&](int row, int at, const Block<double> &block, bool is_transposed) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                result.value[result.row_start[3 * row + i] + 3 * at + j] =
                    is_transposed ? block[3 * j + i] : block[3 * i + j];
    };
    std::vector<int> next(nodes.num_rows(), 0);
    for (int node = 0; node < nodes.num_rows(); ++node) {
        for (int k = matrix.rows.row_start[node]; k < matrix.rows.row_start[node + 1]; ++k) {
            const int other = matrix.rows.column[k];
            put(node, next[node]++, matrix.below[k], false);
            put(other, next[other]++, matrix.below[k], true);
        }
        put(node, next[node]++, matrix.diagonal[node], false);
    }
    return result;
}

} // namespace livermark::fem_reference
