// Vectors in space, one to a lane, and rows of four numbers at scattered places. Written once for each vector unit: see
// explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_VECTORS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_VECTORS_INL_HPP
#undef LIVERMARK_INTERACTIVE_VECTORS_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_VECTORS_INL_HPP
#endif

#include <cstdint>
#include <hwy/highway.h>

#include "interactive/kernels/node_rows.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// As many lanes as the machine has, at most a slice.
using D = hn::CappedTag<float, slice_size>;
using V = hn::Vec<D>;
constexpr D d;

struct Vec3 {
    V x, y, z;
};

struct Row {
    Vec3 v;
    V w;
};

HWY_INLINE V number(float value) {
    return hn::Set(d, value);
}

HWY_INLINE Vec3 operator+(const Vec3 &a, const Vec3 &b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

HWY_INLINE Vec3 operator-(const Vec3 &a, const Vec3 &b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

HWY_INLINE Vec3 minus(const Vec3 &a) {
    return {hn::Neg(a.x), hn::Neg(a.y), hn::Neg(a.z)};
}

HWY_INLINE V dot(const Vec3 &a, const Vec3 &b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

HWY_INLINE Vec3 cross(const Vec3 &a, const Vec3 &b) {
    return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
            hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

HWY_INLINE Vec3 scaled(V factor, const Vec3 &a) {
    return {hn::Mul(factor, a.x), hn::Mul(factor, a.y), hn::Mul(factor, a.z)};
}

/// a + factor b
HWY_INLINE Vec3 plus_scaled(const Vec3 &a, V factor, const Vec3 &b) {
    return {hn::MulAdd(factor, b.x, a.x), hn::MulAdd(factor, b.y, a.y), hn::MulAdd(factor, b.z, a.z)};
}

/// a where a lane is chosen, b elsewhere.
HWY_INLINE Vec3 chosen(hn::Mask<D> lanes, const Vec3 &a, const Vec3 &b) {
    return {hn::IfThenElse(lanes, a.x, b.x), hn::IfThenElse(lanes, a.y, b.y), hn::IfThenElse(lanes, a.z, b.z)};
}

/// r a + s b + t c
HWY_INLINE Vec3 combined(V r, const Vec3 &a, V s, const Vec3 &b, V t, const Vec3 &c) {
    return {hn::MulAdd(r, a.x, hn::MulAdd(s, b.x, hn::Mul(t, c.x))),
            hn::MulAdd(r, a.y, hn::MulAdd(s, b.y, hn::Mul(t, c.y))),
            hn::MulAdd(r, a.z, hn::MulAdd(s, b.z, hn::Mul(t, c.z)))};
}

/// Three vectors that stand behind each other.
HWY_INLINE Vec3 load3(const float *at) {
    return {hn::Load(d, at), hn::Load(d, at + slice_size), hn::Load(d, at + 2 * slice_size)};
}

HWY_INLINE void store3(const Vec3 &v, float *at) {
    hn::Store(v.x, d, at);
    hn::Store(v.y, d, at + slice_size);
    hn::Store(v.z, d, at + 2 * slice_size);
}

/// The first three numbers of rows of four that stand behind each other.
HWY_INLINE Vec3 load_rows(const Aligned<float> &rows, std::size_t first) {
    V x, y, z, w;
    hn::LoadInterleaved4(d, rows.data() + 4 * first, x, y, z, w);
    return {x, y, z};
}

HWY_INLINE void store_rows(const Vec3 &v, Aligned<float> &rows, std::size_t first) {
    hn::StoreInterleaved4(v.x, v.y, v.z, hn::Zero(d), d, rows.data() + 4 * first);
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE Row fetch(const float *rows, const std::int32_t *index) {
    const float *at = rows + *index;
    return {{number(at[0]), number(at[1]), number(at[2])}, number(at[3])};
}

HWY_INLINE void store(const Row &row, float *rows, const std::int32_t *index) {
    float *at = rows + *index;
    hn::Store(row.v.x, d, at);
    hn::Store(row.v.y, d, at + 1);
    hn::Store(row.v.z, d, at + 2);
    hn::Store(row.w, d, at + 3);
}

#else

/// Rows of four, as rows of lanes: lane 4 b + i of component c is number c of block b of r_i; and back again.
struct FourByFour {
    V r0, r1, r2, r3;

    HWY_INLINE FourByFour transposed() const {
        const hn::RepartitionToWide<hn::RebindToUnsigned<D>> pairs;
        const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, r0, r1));
        const auto zw01 = hn::BitCast(pairs, hn::InterleaveUpper(d, r0, r1));
        const auto xy23 = hn::BitCast(pairs, hn::InterleaveLower(d, r2, r3));
        const auto zw23 = hn::BitCast(pairs, hn::InterleaveUpper(d, r2, r3));
        return {hn::BitCast(d, hn::InterleaveLower(pairs, xy01, xy23)),
                hn::BitCast(d, hn::InterleaveUpper(pairs, xy01, xy23)),
                hn::BitCast(d, hn::InterleaveLower(pairs, zw01, zw23)),
                hn::BitCast(d, hn::InterleaveUpper(pairs, zw01, zw23))};
    }
};

// Widths that are not there must not be looked at: so these are templates.

/// Two halves in one. Highway's own way in version 1.0 sets the rest to zero first, which gcc 12 does with an
/// operation.
template <class Tag> HWY_INLINE V joined(Tag tag, hn::Vec<hn::Half<Tag>> upper, hn::Vec<hn::Half<Tag>> lower) {
#if HWY_TARGET <= HWY_AVX3
    if constexpr (hn::MaxLanes(tag) == 16)
        return V{_mm512_insertf32x8(_mm512_castps256_ps512(lower.raw), upper.raw, 1)};
    else
#endif
        return hn::Combine(tag, upper, lower);
}

/// 16 bytes from each of several places: block b of the result from the index of lane 4 b.
template <class Tag> HWY_INLINE hn::Vec<Tag> blocks(Tag tag, const float *rows, const std::int32_t *index) {
    constexpr hn::Full128<float> block;
    const auto load = [&](int b) HWY_ATTR { return hn::LoadU(block, rows + index[4 * b]); };
    if constexpr (hn::MaxLanes(tag) == 4) {
        return load(0);
    } else if constexpr (hn::MaxLanes(tag) == 8) {
        return hn::Combine(tag, load(1), load(0));
    } else {
        const hn::Half<Tag> half;
        return joined(tag, hn::Combine(half, load(3), load(2)), hn::Combine(half, load(1), load(0)));
    }
}

/// Rows at scattered places. Hardware gathers take longer than these loads and the transposition.
HWY_INLINE Row fetch(const float *rows, const std::int32_t *index) {
    const auto [x, y, z, w] = FourByFour{blocks(d, rows, index), blocks(d, rows, index + 1), blocks(d, rows, index + 2),
                                         blocks(d, rows, index + 3)}
                                  .transposed();
    return {{x, y, z}, w};
}

template <class Tag>
HWY_INLINE void store_blocks(Tag tag, hn::Vec<Tag> blocks, float *rows, const std::int32_t *index) {
    if constexpr (hn::MaxLanes(tag) == 4) {
        hn::Store(blocks, tag, rows + index[0]);
    } else {
        const hn::Half<Tag> half;
        store_blocks(half, hn::LowerHalf(half, blocks), rows, index);
        store_blocks(half, hn::UpperHalf(half, blocks), rows, index + hn::MaxLanes(half));
    }
}

/// Rows to scattered places.
HWY_INLINE void store(const Row &row, float *rows, const std::int32_t *index) {
    const auto [r0, r1, r2, r3] = FourByFour{row.v.x, row.v.y, row.v.z, row.w}.transposed();
    store_blocks(d, r0, rows, index);
    store_blocks(d, r1, rows, index + 1);
    store_blocks(d, r2, rows, index + 2);
    store_blocks(d, r3, rows, index + 3);
}

#endif

/// Rows (x, y, z, 0) to scattered places.
HWY_INLINE void store(const Vec3 &v, float *rows, const std::int32_t *index) {
    store(Row{v, hn::Zero(d)}, rows, index);
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_VECTORS_INL_HPP
