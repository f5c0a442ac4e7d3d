#include "fem_reference/solvers/matrices.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace livermark::fem_reference {

namespace {

template <class T> void scale_each(std::span<const double> factor, std::span<T> y) {
    with_lanes(static_cast<int>(factor.size()), [&]<int L>() {
        std::array<T, L> by{};
        std::ranges::transform(factor, by.begin(), [](double value) { return static_cast<T>(value); });
        for (std::size_t i = 0; i < y.size(); i += L)
            for (int c = 0; c < L; ++c)
                y[i + c] *= by[c];
    });
}

template <class T>
void multiply_each(const SymmetricMatrix &matrix, std::span<const T> x, std::span<T> out, int lanes) {
    with_lanes(lanes, [&]<int L>() {
        for (int row = 0; row < matrix.num_rows(); ++row) {
            std::array<T, L> sum{};
            for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k) {
                const T value = static_cast<T>(matrix.value[k]);
                const T *const from = &x[static_cast<std::size_t>(L) * matrix.column[k]];
                for (int c = 0; c < L; ++c)
                    sum[c] += value * from[c];
            }
            std::ranges::copy(sum, &out[static_cast<std::size_t>(L) * row]);
        }
    });
}

} // namespace

int lanes_for(std::size_t num_columns) {
    return num_columns == 1 ? 1 : num_columns <= 4 ? 4 : most_lanes;
}

std::vector<bool> free_of(std::span<const double> prescribed) {
    std::vector<bool> is_free(prescribed.size());
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        is_free[i] = std::isnan(prescribed[i]);
    return is_free;
}

FreeUnknowns free_unknowns(std::span<const std::span<const double>> prescribed) {
    FreeUnknowns free;
    for (const auto &column : prescribed) {
        auto is_free = free_of(column);
        const auto same = std::ranges::find(free.sets, is_free);
        free.set.push_back(static_cast<int>(same - free.sets.begin()));
        if (same == free.sets.end())
            free.sets.push_back(std::move(is_free));
    }
    free.set.resize(lanes_for(prescribed.size()), 0);
    return free;
}

std::vector<std::size_t> constrained_entries(const FreeUnknowns &free) {
    std::vector<std::size_t> entries;
    for (std::size_t i = 0; i < free.sets.front().size(); ++i)
        for (std::size_t c = 0; c < free.set.size(); ++c)
            if (!free.sets[free.set[c]][i])
                entries.push_back(free.set.size() * i + c);
    return entries;
}

void zero(std::span<const std::size_t> entries, std::span<double> vectors) {
    for (const auto entry : entries)
        vectors[entry] = 0.0;
}

void zero(std::span<const std::size_t> entries, std::span<float> vectors) {
    for (const auto entry : entries)
        vectors[entry] = 0.0F;
}

std::vector<std::vector<double>> separated(std::span<const double> together, int lanes, std::size_t num_columns) {
    std::vector<std::vector<double>> columns(num_columns, std::vector<double>(together.size() / lanes));
    for (std::size_t i = 0; i < together.size() / lanes; ++i)
        for (std::size_t c = 0; c < num_columns; ++c)
            columns[c][i] = together[lanes * i + c];
    return columns;
}

std::vector<double> dots(std::span<const double> a, std::span<const double> b, int lanes) {
    std::vector<double> result;
    with_lanes(lanes, [&]<int L>() {
        std::array<double, L> sum{};
        for (std::size_t i = 0; i < a.size(); i += L)
            for (int c = 0; c < L; ++c)
                sum[c] += a[i + c] * b[i + c];
        result.assign(sum.begin(), sum.end());
    });
    return result;
}

std::vector<double> roots_of(std::vector<double> values) {
    for (double &value : values)
        value = std::sqrt(value);
    return values;
}

void scale(std::span<const double> factor, std::span<double> y) {
    scale_each(factor, y);
}

void scale(std::span<const double> factor, std::span<float> y) {
    scale_each(factor, y);
}

void multiply(const SymmetricMatrix &matrix, std::span<const double> x, std::span<double> out, int lanes) {
    multiply_each(matrix, x, out, lanes);
}

void multiply(const SymmetricMatrix &matrix, std::span<const float> x, std::span<float> out, int lanes) {
    multiply_each(matrix, x, out, lanes);
}

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

namespace {

/// Some lanes of one number.
template <class T, int some> struct Single {
    typename Lanes<T, some>::Numbers value{};

    Single() = default;
    [[gnu::always_inline]] explicit Single(const T *place) { std::memcpy(&value, place, sizeof value); }
    [[gnu::always_inline]] void put(T *place) const { std::memcpy(place, &value, sizeof value); }
};

template <class T, int some, int lanes>
[[gnu::always_inline]] inline void add_dot(const std::array<T, 3> &row, const Triple<T, some, lanes> &vector,
                                           Single<T, some> &sum) {
    sum.value += row[0] * vector.x + row[1] * vector.y + row[2] * vector.z;
}

/// @tparam first, some  the lanes that are looked at, as in SymmetricBlocks
template <int lanes, int first, int some, class T>
[[gnu::always_inline]] inline void less_of_row(const DivergenceRows<T> &d, std::size_t q, const T *u, const T *g,
                                               T *out) {
    Single<T, some> sum;
    for (int k = d.row_start[q]; k < d.row_start[q + 1]; ++k)
        add_dot(d.value[k], Triple<T, some, lanes>(u + std::size_t{3} * lanes * d.column[k] + first), sum);
    sum.value -= Single<T, some>(g + lanes * q + first).value;
    sum.put(out + lanes * q + first);
}

template <int lanes, int first, int some, class T>
[[gnu::always_inline]] inline void products_of_row(const DivergenceRows<T> &d, std::size_t q, const T *u, const T *p,
                                                   T *force, T *imbalance) {
    Single<T, some> sum;
    const Single<T, some> in_row(p + lanes * q + first);
    for (int k = d.row_start[q]; k < d.row_start[q + 1]; ++k) {
        const auto place = std::size_t{3} * lanes * d.column[k] + first;
        const auto &value = d.value[k];
        add_dot(value, Triple<T, some, lanes>(u + place), sum);
        Triple<T, some, lanes> there(force + place);
        there.x += value[0] * in_row.value;
        there.y += value[1] * in_row.value;
        there.z += value[2] * in_row.value;
        there.put(force + place);
    }
    sum.value -= Single<T, some>(imbalance + lanes * q + first).value;
    sum.put(imbalance + lanes * q + first);
}

/// As many lanes as a vector of the processor holds.
template <class T, int lanes> constexpr int at_once = std::min<int>(lanes, 32 / sizeof(T));

template <int lanes, class T>
[[gnu::always_inline]] inline void less(const DivergenceRows<T> &d, const T *u, const T *g, T *out) {
    constexpr int some = at_once<T, lanes>;
    for (std::size_t q = 0; q < d.num_rows(); ++q) {
        less_of_row<lanes, 0, some>(d, q, u, g, out);
        if constexpr (lanes > some)
            less_of_row<lanes, some, lanes - some>(d, q, u, g, out);
    }
}

template <int lanes, class T>
[[gnu::always_inline]] inline void products(const DivergenceRows<T> &d, const T *u, const T *p, T *force,
                                            T *imbalance) {
    constexpr int some = at_once<T, lanes>;
    for (std::size_t q = 0; q < d.num_rows(); ++q) {
        products_of_row<lanes, 0, some>(d, q, u, p, force, imbalance);
        if constexpr (lanes > some)
            products_of_row<lanes, some, lanes - some>(d, q, u, p, force, imbalance);
    }
}

template <class T>
[[gnu::always_inline]] inline void less_of_lanes(const DivergenceRows<T> &d, const T *u, const T *g, T *out,
                                                 int lanes) {
    switch (lanes) { // a lambda would be compiled for one processor
    case 1:
        return less<1>(d, u, g, out);
    case 4:
        return less<4>(d, u, g, out);
    default:
        return less<most_lanes>(d, u, g, out);
    }
}

template <class T>
[[gnu::always_inline]] inline void products_of_lanes(const DivergenceRows<T> &d, const T *u, const T *p, T *force,
                                                     T *imbalance, int lanes) {
    switch (lanes) {
    case 1:
        return products<1>(d, u, p, force, imbalance);
    case 4:
        return products<4>(d, u, p, force, imbalance);
    default:
        return products<most_lanes>(d, u, p, force, imbalance);
    }
}

} // namespace

template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<float>::subtract_product(std::span<const float> u, std::span<const float> g,
                                                                   std::span<float> out, int lanes) const {
    less_of_lanes(*this, u.data(), g.data(), out.data(), lanes);
}
template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<double>::subtract_product(std::span<const double> u,
                                                                    std::span<const double> g, std::span<double> out,
                                                                    int lanes) const {
    less_of_lanes(*this, u.data(), g.data(), out.data(), lanes);
}
template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<float>::add_products(std::span<const float> u, std::span<const float> p,
                                                               std::span<float> force, std::span<float> imbalance,
                                                               int lanes) const {
    products_of_lanes(*this, u.data(), p.data(), force.data(), imbalance.data(), lanes);
}
template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<double>::add_products(std::span<const double> u, std::span<const double> p,
                                                                std::span<double> force, std::span<double> imbalance,
                                                                int lanes) const {
    products_of_lanes(*this, u.data(), p.data(), force.data(), imbalance.data(), lanes);
}

DivergenceRows<float> rounded(const DivergenceRows<double> &matrix) {
    DivergenceRows<float> result{matrix.row_start, matrix.column, {}};
    result.value.reserve(matrix.value.size());
    for (const auto &value : matrix.value)
        std::ranges::transform(value, result.value.emplace_back().begin(),
                               [](double x) { return static_cast<float>(x); });
    return result;
}

namespace {

/// Occurrences of each row in the rows of the cells, in their order.
struct Occurrences {
    std::vector<std::size_t> start; ///< (rows + 1) index into at
    std::vector<std::size_t> at;    ///< index into the rows of the cells
};

Occurrences occurrences(std::span<const int> rows, int num_rows) {
    Occurrences of{std::vector<std::size_t>(static_cast<std::size_t>(num_rows) + 1, 0), {}};
    for (const int row : rows)
        if (row >= 0)
            ++of.start[row + 1];
    for (int row = 0; row < num_rows; ++row)
        of.start[row + 1] += of.start[row];
    of.at.resize(of.start.back());
    auto next = of.start;
    for (std::size_t k = 0; k < rows.size(); ++k)
        if (rows[k] >= 0)
            of.at[next[rows[k]]++] = k;
    return of;
}

} // namespace

CellRows cell_rows(std::span<const int> rows, int rows_per_cell, int num_rows, std::span<const int> columns,
                   int columns_per_cell, int num_columns, CellEntries wanted) {
    const auto of = occurrences(rows, num_rows);
    CellRows result{{0}, {}, std::vector<int>(rows.size() * columns_per_cell, -1)};
    std::vector<int> last_row(num_columns, -1), place(num_columns); // of each column
    const auto for_each_column = [&](int row, const auto &action) {
        for (auto k = of.start[row]; k < of.start[row + 1]; ++k) {
            const auto cell = of.at[k] / static_cast<std::size_t>(rows_per_cell);
            for (int b = 0; b < columns_per_cell; ++b)
                if (const int column = columns[cell * columns_per_cell + b]; wanted == CellEntries::all || column < row)
                    action(column, of.at[k] * columns_per_cell + b);
        }
    };
    for (int row = 0; row < num_rows; ++row) {
        const auto first = static_cast<std::ptrdiff_t>(result.column.size());
        for_each_column(row, [&](int column, std::size_t /*pair*/) {
            if (last_row[column] != row) {
                last_row[column] = row;
                result.column.push_back(column);
            }
        });
        std::sort(result.column.begin() + first, result.column.end());
        for (auto at = static_cast<std::size_t>(first); at < result.column.size(); ++at)
            place[result.column[at]] = static_cast<int>(at);
        for_each_column(row, [&](int column, std::size_t pair) { result.place[pair] = place[column]; });
        result.row_start.push_back(static_cast<int>(result.column.size()));
    }
    return result;
}

} // namespace livermark::fem_reference
