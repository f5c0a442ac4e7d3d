#pragma once

#include <array>
#include <cstring>

namespace livermark::fem_reference {

/// In front of a function whose loops are worth the vectors of newer processors: compiled for them too, and chosen when
/// the program starts.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define LIVERMARK_WIDE_CLONES [[gnu::target_clones("arch=x86-64-v3", "default")]]
#else
#define LIVERMARK_WIDE_CLONES
#endif

/// Vectors of three padded to four, so that a processor takes one at once; the last component is zero.
template <class T> using Padded = std::array<T, 4>;

/// A 3 x 3 block by rows. A fourth number of a row is read with it: the first of what comes next in memory, which has
/// to be finite, and is multiplied by zero or not looked at.
template <class T> using Block = std::array<T, 9>;

/// Four numbers that a processor takes at once. They are passed by reference: how they go by value depends on the
/// processor that a function is compiled for.
template <class T> struct Quad {
    using Lanes [[gnu::vector_size(4 * sizeof(T))]] = T;
    Lanes lanes{};

    Quad() = default;
    [[gnu::always_inline]] explicit Quad(const T *place) { std::memcpy(&lanes, place, sizeof lanes); }
    [[gnu::always_inline]] void put(T *place) const { std::memcpy(place, &lanes, sizeof lanes); }
};

/// Asks for a block that a loop over the blocks in memory comes to a while after this one: a processor that waits to
/// see where the loop goes reads at half the speed.
/// @param direction  1 or -1, of the loop
template <class T> [[gnu::always_inline]] inline void ask_ahead(const Block<T> *block, int direction) {
    constexpr int blocks_ahead = 64;
    __builtin_prefetch(block + direction * blocks_ahead);
}

/// What a row of blocks makes of the vectors that it is multiplied with. The products of each of the three rows are
/// added lane by lane, and the lanes only when the row is done.
template <class T> class RowSum {
  public:
    [[gnu::always_inline]] void add(const T *block, const T *vector) {
        const Quad<T> v(vector);
        x_.lanes += Quad<T>(block).lanes * v.lanes;
        y_.lanes += Quad<T>(block + 3).lanes * v.lanes;
        z_.lanes += Quad<T>(block + 6).lanes * v.lanes;
    }
    [[gnu::always_inline]] std::array<T, 3> total() const {
        const auto sum = [](const Quad<T> &q) { return q.lanes[0] + q.lanes[1] + q.lanes[2]; };
        return {sum(x_), sum(y_), sum(z_)};
    }

  private:
    Quad<T> x_, y_, z_;
};

/// sum += block^T vector; the last lane of the sum is then anything.
template <class T> [[gnu::always_inline]] inline void add_transposed(const T *block, const T *vector, T *sum) {
    Quad<T> result(sum);
    result.lanes += Quad<T>(block).lanes * vector[0];
    result.lanes += Quad<T>(block + 3).lanes * vector[1];
    result.lanes += Quad<T>(block + 6).lanes * vector[2];
    result.put(sum);
}

} // namespace livermark::fem_reference
