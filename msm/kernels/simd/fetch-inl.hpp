// Rows of four numbers at scattered places, one to a lane, as four vectors. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_FETCH_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_FETCH_INL_HPP
#undef LIVERMARK_FETCH_INL_HPP
#else
#define LIVERMARK_FETCH_INL_HPP
#endif

#include <cstdint>
#include <hwy/highway.h>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// As many lanes as the machine has, at most a slice of float; a double has half of them.
template <class T> using Lanes = hn::CappedTag<T, 64 / sizeof(T)>;

template <class D> struct Rows { hn::Vec<D> x, y, z, w; };

#if HWY_TARGET == HWY_SCALAR

template <class D, class T> HWY_INLINE Rows<D> fetch(D d, const T *rows, const std::int32_t *index) {
    const T *at = rows + *index;
    return {hn::Set(d, at[0]), hn::Set(d, at[1]), hn::Set(d, at[2]), hn::Set(d, at[3])};
}

template <class D> struct Blocks { hn::Vec<D> r0, r1, r2, r3; };
template <class D, class T> HWY_INLINE Blocks<D> fetch_blocks(D d, const T *rows, const std::int32_t *index) {
    const auto row = fetch(d, rows, index);
    return {row.x, row.y, row.z, row.w};
}
template <class D> HWY_INLINE Rows<D> transposed(D /*d*/, const Blocks<D> &blocks) {
    return {blocks.r0, blocks.r1, blocks.r2, blocks.r3};
}

template <class D, class V, class T>
HWY_INLINE void scatter_add(D d, V x, V y, V z, T *rows, const std::int32_t *index) {
    const auto was = fetch(d, rows, index);
    hn::StoreInterleaved4(hn::Add(was.x, x), hn::Add(was.y, y), hn::Add(was.z, z), was.w, d, rows + *index);
}

#else

/// Two halves in one. Highway's own way in version 1.0 sets the rest to zero first, which gcc 12 does with an
/// operation.
template <class D, class T = hn::TFromD<D>>
HWY_INLINE hn::Vec<D> joined(D d, hn::Vec<hn::Half<D>> upper, hn::Vec<hn::Half<D>> lower) {
#if HWY_TARGET <= HWY_AVX3
    if constexpr (std::is_same_v<hn::Vec<D>, hn::Vec512<float>>)
        return hn::Vec512<float>{_mm512_insertf32x8(_mm512_castps256_ps512(lower.raw), upper.raw, 1)};
    else if constexpr (std::is_same_v<hn::Vec<D>, hn::Vec512<double>>)
        return hn::Vec512<double>{_mm512_insertf64x4(_mm512_castpd256_pd512(lower.raw), upper.raw, 1)};
    else
#endif
        return hn::Combine(d, upper, lower);
}

/// 16 bytes from each of several places: block b of the result from the index of lane `stride * b`. An index is four
/// times a row: the processor would need an instruction more for each to find that out.
template <class D, class T = hn::TFromD<D>>
HWY_INLINE hn::Vec<D> blocks(D d, const T *rows, const std::int32_t *index, int stride) {
    constexpr hn::Full128<T> block;
    const auto load = [&](int b) HWY_ATTR { return hn::LoadU(block, rows + index[b]); };
    if constexpr (hn::MaxLanes(d) * sizeof(T) == 16) {
        return load(0);
    } else if constexpr (hn::MaxLanes(d) * sizeof(T) == 32) {
        return hn::Combine(d, load(stride), load(0));
    } else {
        const hn::Half<D> half;
        return joined(d, hn::Combine(half, load(3 * stride), load(2 * stride)),
                      hn::Combine(half, load(stride), load(0)));
    }
}

/// Such rows as they are loaded. Sums of rows are made of them, and then one transposition.
template <class D> struct Blocks { hn::Vec<D> r0, r1, r2, r3; };

template <class D> HWY_INLINE Blocks<D> fetch_blocks(D d, const float *rows, const std::int32_t *index) {
    return {blocks(d, rows, index, 4), blocks(d, rows, index + 1, 4), blocks(d, rows, index + 2, 4),
            blocks(d, rows, index + 3, 4)};
}
template <class D> HWY_INLINE Blocks<D> fetch_blocks(D d, const double *rows, const std::int32_t *index) {
    return {blocks(d, rows, index, 2), blocks(d, rows, index + 1, 2), blocks(d, rows + 2, index, 2),
            blocks(d, rows + 2, index + 1, 2)};
}

template <class D> HWY_INLINE Rows<D> transposed(D d, const Blocks<D> &blocks) {
    const auto &[r0, r1, r2, r3] = blocks;
    if constexpr (sizeof(hn::TFromD<D>) == 8) {
        return {hn::InterleaveLower(d, r0, r1), hn::InterleaveUpper(d, r0, r1), hn::InterleaveLower(d, r2, r3),
                hn::InterleaveUpper(d, r2, r3)};
    } else {
        const hn::RepartitionToWide<decltype(hn::RebindToUnsigned<D>())> pairs;
        const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, r0, r1));
        const auto zw01 = hn::BitCast(pairs, hn::InterleaveUpper(d, r0, r1));
        const auto xy23 = hn::BitCast(pairs, hn::InterleaveLower(d, r2, r3));
        const auto zw23 = hn::BitCast(pairs, hn::InterleaveUpper(d, r2, r3));
        return {hn::BitCast(d, hn::InterleaveLower(pairs, xy01, xy23)),
                hn::BitCast(d, hn::InterleaveUpper(pairs, xy01, xy23)),
                hn::BitCast(d, hn::InterleaveLower(pairs, zw01, zw23)),
                hn::BitCast(d, hn::InterleaveUpper(pairs, zw01, zw23))};
    }
}

/// Hardware gathers three vectors in three times the time that these loads and the transposition take.
template <class D, class T> HWY_INLINE Rows<D> fetch(D d, const T *rows, const std::int32_t *index) {
    return transposed(d, fetch_blocks(d, rows, index));
}

/// Adds 16 bytes to each of several places, one after the other, so that two of these may be one. The compiler makes
/// operations on registers of the way through memory; if it may not, everything with tetrahedra is a tenth slower.
template <class D, class V, class T = hn::TFromD<D>>
HWY_INLINE void add_blocks(D d, V blocks, T *rows, const std::int32_t *index, int stride) {
    constexpr hn::Full128<T> block;
    constexpr int block_size = 16 / sizeof(T);
    HWY_ALIGN T parts[hn::MaxLanes(D())];
    hn::Store(blocks, d, parts);
    for (int b = 0; b < static_cast<int>(hn::MaxLanes(D())) / block_size; ++b) {
        T *at = rows + index[b * stride];
        hn::StoreU(hn::Add(hn::LoadU(block, at), hn::Load(block, parts + b * block_size)), block, at);
    }
}

/// Adds rows (x, y, z, 0) at scattered places.
template <class D, class V> HWY_INLINE void scatter_add(D d, V x, V y, V z, float *rows, const std::int32_t *index) {
    const hn::RepartitionToWide<decltype(hn::RebindToUnsigned<D>())> pairs;
    const auto zero = hn::Zero(d);
    const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, x, y));
    const auto xy23 = hn::BitCast(pairs, hn::InterleaveUpper(d, x, y));
    const auto zw01 = hn::BitCast(pairs, hn::InterleaveLower(d, z, zero));
    const auto zw23 = hn::BitCast(pairs, hn::InterleaveUpper(d, z, zero));
    add_blocks(d, hn::BitCast(d, hn::InterleaveLower(pairs, xy01, zw01)), rows, index, 4);
    add_blocks(d, hn::BitCast(d, hn::InterleaveUpper(pairs, xy01, zw01)), rows, index + 1, 4);
    add_blocks(d, hn::BitCast(d, hn::InterleaveLower(pairs, xy23, zw23)), rows, index + 2, 4);
    add_blocks(d, hn::BitCast(d, hn::InterleaveUpper(pairs, xy23, zw23)), rows, index + 3, 4);
}

template <class D, class V> HWY_INLINE void scatter_add(D d, V x, V y, V z, double *rows, const std::int32_t *index) {
    const auto zero = hn::Zero(d);
    add_blocks(d, hn::InterleaveLower(d, x, y), rows, index, 2);
    add_blocks(d, hn::InterleaveUpper(d, x, y), rows, index + 1, 2);
    add_blocks(d, hn::InterleaveLower(d, z, zero), rows + 2, index, 2);
    add_blocks(d, hn::InterleaveUpper(d, z, zero), rows + 2, index + 1, 2);
}

#endif

template <class D> HWY_INLINE Blocks<D> plus(const Blocks<D> &a, const Blocks<D> &b) {
    return {hn::Add(a.r0, b.r0), hn::Add(a.r1, b.r1), hn::Add(a.r2, b.r2), hn::Add(a.r3, b.r3)};
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_FETCH_INL_HPP
