#pragma once

#include <span>
#include <vector>

#include "fem_reference/solvers/symmetric_matrix.hpp"

namespace livermark::fem_reference {

/// Vectors that are worked on together, so that a matrix comes from memory once for all of them: entry i of column c is
/// at lanes * i + c. Vector units take 1, 4 or 8 lanes at once; lanes that no column needs stay zero.
inline constexpr int most_lanes = 8;

/// The least number of lanes for 1 to most_lanes columns.
int lanes_for(std::size_t num_columns);

/// Calls action.operator()<lanes>(): the loops over the lanes are then of a length that the compiler knows.
template <class Action> [[gnu::always_inline]] inline void with_lanes(int lanes, const Action &action) {
    switch (lanes) {
    case 1:
        return action.template operator()<1>();
    case 4:
        return action.template operator()<4>();
    default:
        return action.template operator()<most_lanes>();
    }
}

/// Which unknowns are free, in each column.
struct FreeUnknowns {
    std::vector<std::vector<bool>> sets; ///< different ones, each (n)
    std::vector<int> set;                ///< (lanes) that of each column; of lanes that no column needs, the first

    int lanes() const { return static_cast<int>(set.size()); }
    bool operator==(const FreeUnknowns &) const = default;
};

/// @param prescribed  of 1 to most_lanes columns, (n) each, NaN where an unknown is free
FreeUnknowns free_unknowns(std::span<const std::span<const double>> prescribed);

/// Where the entries of unknowns that are not free stand.
std::vector<std::size_t> constrained_entries(const FreeUnknowns &free);

/// Puts zeros there.
void zero(std::span<const std::size_t> entries, std::span<double> vectors);
void zero(std::span<const std::size_t> entries, std::span<float> vectors);

/// The same vectors, one behind the other in memory.
/// @return (columns)(n)
std::vector<std::vector<double>> separated(std::span<const double> together, int lanes, std::size_t num_columns);

/// a_c . b_c
/// @return shape (lanes)
std::vector<double> dots(std::span<const double> a, std::span<const double> b, int lanes);

/// Their square roots.
std::vector<double> roots_of(std::vector<double> values);

/// y_c = factor_c y_c
/// @param factor  shape (lanes)
void scale(std::span<const double> factor, std::span<double> y);
void scale(std::span<const double> factor, std::span<float> y);

/// out_c = A x_c
/// @param x, out  shape (num_rows, lanes), not the same
void multiply(const SymmetricMatrix &matrix, std::span<const double> x, std::span<double> out, int lanes = 1);
void multiply(const SymmetricMatrix &matrix, std::span<const float> x, std::span<float> out, int lanes = 1);

} // namespace livermark::fem_reference
