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

} // namespace livermark::fem_reference
