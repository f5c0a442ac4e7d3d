#include "fem_reference/solvers/multivector.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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

FreeUnknowns free_unknowns(std::span<const std::span<const double>> prescribed) {
    FreeUnknowns free;
    for (const auto &column : prescribed) {
        std::vector<bool> is_free(column.size());
        for (std::size_t i = 0; i < column.size(); ++i)
            is_free[i] = std::isnan(column[i]);
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

} // namespace livermark::fem_reference
