#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

namespace livermark::fem_reference {

/// A symmetric sparse matrix in compressed rows (or columns, it is the same): both triangles, columns ascending.
struct SymmetricMatrix {
    std::vector<int> row_start; ///< (n + 1) index into column and value
    std::vector<int> column;    ///< (nonzeros)
    std::vector<double> value;  ///< (nonzeros)

    int num_rows() const { return static_cast<int>(row_start.size()) - 1; }
};

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

/// Whether each unknown is free.
/// @param prescribed  shape (n), NaN where an unknown is free
std::vector<bool> free_of(std::span<const double> prescribed);

/// Free unknowns of each column.
struct FreeUnknowns {
    std::vector<std::vector<bool>> sets; ///< different ones, each (n)
    std::vector<int> set;                ///< (lanes) that of each column; of lanes that no column needs, the first

    int lanes() const { return static_cast<int>(set.size()); }
    bool operator==(const FreeUnknowns &) const = default;
};

/// @param prescribed  of 1 to most_lanes columns, (n) each, NaN where an unknown is free
FreeUnknowns free_unknowns(std::span<const std::span<const double>> prescribed);

/// Places of the entries of unknowns that are not free.
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

/// In front of a function whose loops are worth the vectors of newer processors: compiled for them too, and chosen when
/// the program starts.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define LIVERMARK_WIDE_CLONES [[gnu::target_clones("arch=x86-64-v3", "default")]]
#else
#define LIVERMARK_WIDE_CLONES
#endif

/// A 3 x 3 block by rows.
template <class T> using Block = std::array<T, 9>;

/// One number of each of the vectors that are worked on together.
template <class T, int lanes> struct Lanes { using Numbers [[gnu::vector_size(lanes * sizeof(T))]] = T; };
template <class T> struct Lanes<T, 1> { using Numbers = T; };

/// Three components of some of the vectors that are worked on together.
/// They are passed by reference: how they go by value depends on the processor that a function is compiled for.
/// @tparam lanes   of these vectors
/// @tparam stride  from one component to the next in memory: the lanes of all vectors
template <class T, int lanes, int stride = lanes> struct Triple {
    using Numbers = typename Lanes<T, lanes>::Numbers;
    Numbers x{}, y{}, z{};

    Triple() = default;
    [[gnu::always_inline]] explicit Triple(const T *place) {
        std::memcpy(&x, place, sizeof x);
        std::memcpy(&y, place + stride, sizeof y);
        std::memcpy(&z, place + 2 * stride, sizeof z);
    }
    [[gnu::always_inline]] void put(T *place) const {
        std::memcpy(place, &x, sizeof x);
        std::memcpy(place + stride, &y, sizeof y);
        std::memcpy(place + 2 * stride, &z, sizeof z);
    }
};

/// Asks for a block that a loop over the blocks in memory comes to a while after this one: a processor that waits to
/// see where the loop goes reads at half the speed.
/// @param direction  1 or -1, of the loop
template <class T> [[gnu::always_inline]] inline void ask_ahead(const Block<T> *block, int direction) {
    constexpr int blocks_ahead = 64;
    __builtin_prefetch(block + direction * blocks_ahead);
}

/// sum += block vector
template <class T, int lanes, int stride>
[[gnu::always_inline]] inline void add_product(const Block<T> &block, const Triple<T, lanes, stride> &vector,
                                               Triple<T, lanes, stride> &sum) {
    sum.x += block[0] * vector.x + block[1] * vector.y + block[2] * vector.z;
    sum.y += block[3] * vector.x + block[4] * vector.y + block[5] * vector.z;
    sum.z += block[6] * vector.x + block[7] * vector.y + block[8] * vector.z;
}

/// sum += block^T vector
template <class T, int lanes, int stride>
[[gnu::always_inline]] inline void add_transposed(const Block<T> &block, const Triple<T, lanes, stride> &vector,
                                                  Triple<T, lanes, stride> &sum) {
    sum.x += block[0] * vector.x + block[3] * vector.y + block[6] * vector.z;
    sum.y += block[1] * vector.x + block[4] * vector.y + block[7] * vector.z;
    sum.z += block[2] * vector.x + block[5] * vector.y + block[8] * vector.z;
}

/// Places of the 3 x 3 blocks below the diagonal.
struct LowerRows {
    std::vector<int> row_start; ///< (n + 1)
    std::vector<int> column;    ///< (blocks) ascending in each row
    std::size_t num_nodes() const { return row_start.size() - 1; }
};

/// The stiffness of n nodes: of its 3 x 3 blocks those on and below the diagonal, one column number each, which is 40 %
/// of what compressed rows hold. Products take as long as its bytes take to come. Neighbours should be near each other,
/// see NodeOrder.
/// @tparam T  double, or float where products may be rough: that is half of the bytes
template <class T> struct SymmetricBlocks {
    LowerRows rows;
    std::vector<Block<T>> below;    ///< (blocks) by rows
    std::vector<Block<T>> diagonal; ///< (n)

    int num_rows() const { return 3 * static_cast<int>(diagonal.size()); }

    /// out_c = K x_c
    /// @param x, out  shape (3 n, lanes); not the same
    void multiply(std::span<const T> x, std::span<T> out) const;
};

template <> void SymmetricBlocks<float>::multiply(std::span<const float> x, std::span<float> out) const;
template <> void SymmetricBlocks<double>::multiply(std::span<const double> x, std::span<double> out) const;

SymmetricBlocks<float> rounded(const SymmetricBlocks<double> &matrix);

/// The same matrix as a factorisation wants it.
/// @return shape (3 n, 3 n)
SymmetricMatrix compressed_rows(const SymmetricBlocks<double> &matrix);

/// Place of the entry of a row and a column, which has to be there, in compressed rows of ascending columns.
inline int place_of_entry(const std::vector<int> &row_start, const std::vector<int> &column, int row, int wanted) {
    const auto first = column.begin() + row_start[row], last = column.begin() + row_start[row + 1];
    return static_cast<int>(std::lower_bound(first, last, wanted) - column.begin());
}

/// One entry for each block of the whole matrix, and all of them zero.
/// @return shape (n, n)
SymmetricMatrix zero_of_blocks(const LowerRows &rows);

/// A matrix D of m pressures and 3 n displacements, by rows: all three components of a node stand together.
/// @tparam T  double, or float where products may be rough: that is little more than half of the bytes
template <class T> struct DivergenceRows {
    std::vector<int> row_start;          ///< (m + 1) index into column and value
    std::vector<int> column;             ///< (nodes of all rows) ascending in each row
    std::vector<std::array<T, 3>> value; ///< (nodes of all rows) of the components of the node

    std::size_t num_rows() const { return row_start.size() - 1; }

    /// out_c = D u_c - g_c
    /// @param u       shape (3 n, lanes)
    /// @param g, out  shape (m, lanes)
    void subtract_product(std::span<const T> u, std::span<const T> g, std::span<T> out, int lanes) const;

    /// force_c += D^T p_c, and imbalance_c = D u_c - imbalance_c
    /// @param u, force      shape (3 n, lanes)
    /// @param p, imbalance  shape (m, lanes)
    void add_products(std::span<const T> u, std::span<const T> p, std::span<T> force, std::span<T> imbalance,
                      int lanes) const;
};

template <>
void DivergenceRows<float>::subtract_product(std::span<const float> u, std::span<const float> g, std::span<float> out,
                                             int lanes) const;
template <>
void DivergenceRows<float>::add_products(std::span<const float> u, std::span<const float> p, std::span<float> force,
                                         std::span<float> imbalance, int lanes) const;
template <>
void DivergenceRows<double>::subtract_product(std::span<const double> u, std::span<const double> g,
                                              std::span<double> out, int lanes) const;
template <>
void DivergenceRows<double>::add_products(std::span<const double> u, std::span<const double> p, std::span<double> force,
                                          std::span<double> imbalance, int lanes) const;

DivergenceRows<float> rounded(const DivergenceRows<double> &matrix);

/// A matrix as deal.II's solvers take it: out = A in.
template <class Action> struct Operator {
    Action action; ///< (out, in)
    template <class Vector> void vmult(Vector &out, const Vector &in) const { action(out, in); }
};
template <class Action> Operator(Action) -> Operator<Action>;

/// Zeros where nothing is free: so a solver takes the rows and columns of what is free alone.
/// @param values   shape (3 n)
/// @param is_free  shape (3 n)
template <class T> void clear_constrained(std::span<T> values, const std::vector<bool> &is_free) {
    for (std::size_t dof = 0; dof < values.size(); ++dof)
        if (!is_free[dof])
            values[dof] = T(0);
}

/// Entries of a sparse matrix that have numbers of the same cell as their row and column, and where those of each cell
/// stand, so that an assembly looks for none.
struct CellRows {
    std::vector<int> row_start; ///< (rows + 1)
    std::vector<int> column;    ///< (entries) ascending in each row
    std::vector<int> place;     ///< (M, a cell's rows, its columns) index into column; -1 of what has no entry
};

enum class CellEntries { all, below_diagonal };

/// @param rows     (M, rows_per_cell) numbers of the rows that a cell adds to, different ones; -1 of none
/// @param columns  (M, columns_per_cell) numbers of its columns, none below 0 where it has a row
CellRows cell_rows(std::span<const int> rows, int rows_per_cell, int num_rows, std::span<const int> columns,
                   int columns_per_cell, int num_columns, CellEntries wanted = CellEntries::all);

} // namespace livermark::fem_reference
