// Vectors in space, one to a lane, rows of four numbers at scattered places, and the parts of steps that all methods
// share. Written once for each vector unit: see explicit_steps.cpp.
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

struct Symmetric {
    V xx, xy, xz, yy, yz, zz;
};

/// The inverse of a matrix A times det A, and det A.
struct Adjugate {
    Symmetric matrix;
    V determinant;
};

HWY_INLINE Adjugate adjugate_of(const Symmetric &a) {
    const auto minor = [](V p, V q, V r, V s) HWY_ATTR { return hn::MulSub(p, q, hn::Mul(r, s)); };
    const Symmetric matrix{minor(a.yy, a.zz, a.yz, a.yz), minor(a.xz, a.yz, a.xy, a.zz), minor(a.xy, a.yz, a.xz, a.yy),
                           minor(a.xx, a.zz, a.xz, a.xz), minor(a.xy, a.xz, a.xx, a.yz), minor(a.xx, a.yy, a.xy, a.xy)};
    return {matrix, hn::MulAdd(a.xx, matrix.xx, hn::MulAdd(a.xy, matrix.xy, hn::Mul(a.xz, matrix.xz)))};
}

HWY_INLINE Symmetric scaled(V factor, const Symmetric &a) {
    return {hn::Mul(factor, a.xx), hn::Mul(factor, a.xy), hn::Mul(factor, a.xz),
            hn::Mul(factor, a.yy), hn::Mul(factor, a.yz), hn::Mul(factor, a.zz)};
}

HWY_INLINE Vec3 product(const Symmetric &a, const Vec3 &b) {
    return {hn::MulAdd(a.xx, b.x, hn::MulAdd(a.xy, b.y, hn::Mul(a.xz, b.z))),
            hn::MulAdd(a.xy, b.x, hn::MulAdd(a.yy, b.y, hn::Mul(a.yz, b.z))),
            hn::MulAdd(a.xz, b.x, hn::MulAdd(a.yz, b.y, hn::Mul(a.zz, b.z)))};
}

/// A += factor v v^T
HWY_INLINE void add_outer(Symmetric &a, V factor, const Vec3 &v) {
    const auto x = hn::Mul(factor, v.x), y = hn::Mul(factor, v.y), z = hn::Mul(factor, v.z);
    a.xx = hn::MulAdd(x, v.x, a.xx);
    a.xy = hn::MulAdd(x, v.y, a.xy);
    a.xz = hn::MulAdd(x, v.z, a.xz);
    a.yy = hn::MulAdd(y, v.y, a.yy);
    a.yz = hn::MulAdd(y, v.z, a.yz);
    a.zz = hn::MulAdd(z, v.z, a.zz);
}

struct StretchedSpring {
    Vec3 now; ///< from one end to the other
    V length, change;

    /// |d| - l = (2 X + u) . u / (|d| + l) keeps the digits of small strains.
    /// @param rest            X, from one end to the other at rest
    /// @param moved           u, the difference of their displacements
    /// @param length_at_rest  l
    HWY_INLINE StretchedSpring(const Vec3 &rest, const Vec3 &moved, V length_at_rest)
        : now(rest + moved), length(hn::Sqrt(dot(now, now))),
          change(hn::Div(dot(rest + now, moved), hn::Add(length, length_at_rest))) {}
};

/// Moves nodes to where they go without elasticity; constrained ones go where their velocities take them.
/// @param rows     with displacement, velocity, external and inverse_mass, rows of four
/// @param before   displacement when the step began
/// @param damping  1 + alpha h
template <class Rows> HWY_NOINLINE void predict(Rows &rows, Aligned<float> &before, float step, float damping) {
    const auto h = number(step), inverse_damping = number(1.0F / damping);
    for (std::size_t at = 0; at < rows.displacement.size(); at += hn::Lanes(d)) {
        const auto inverse_mass = hn::Load(d, rows.inverse_mass.data() + at);
        const auto was = hn::Load(d, rows.displacement.data() + at);
        const auto velocity = hn::Load(d, rows.velocity.data() + at);
        const auto pushed = hn::MulAdd(hn::Mul(h, inverse_mass), hn::Load(d, rows.external.data() + at), velocity);
        const auto is_free = hn::Gt(inverse_mass, hn::Zero(d));
        const auto factor = hn::IfThenElse(is_free, hn::Mul(h, inverse_damping), h);
        hn::Store(was, d, before.data() + at);
        hn::Store(hn::MulAdd(factor, pushed, was), d, rows.displacement.data() + at);
    }
}

template <class Rows> HWY_NOINLINE void find_velocities(Rows &rows, const Aligned<float> &before, float per_second) {
    for (std::size_t at = 0; at < rows.displacement.size(); at += hn::Lanes(d))
        hn::Store(hn::Mul(number(per_second),
                          hn::Sub(hn::Load(d, rows.displacement.data() + at), hn::Load(d, before.data() + at))),
                  d, rows.velocity.data() + at);
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_VECTORS_INL_HPP
