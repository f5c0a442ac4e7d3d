// Vectors in space, one to a lane, with strains and stresses. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_VECTORS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_VECTORS_INL_HPP
#undef LIVERMARK_VECTORS_INL_HPP
#else
#define LIVERMARK_VECTORS_INL_HPP
#endif

#include <algorithm>
#include <cstdint>
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>
#include <type_traits>

#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

// Rows of four numbers at scattered places, one to a lane, as four vectors.

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

template <class D> struct Vec3 { hn::Vec<D> x, y, z; };

template <class D> HWY_INLINE Vec3<D> difference(const Rows<D> &a, const Rows<D> &b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

template <class D> HWY_INLINE hn::Vec<D> dot(const Vec3<D> &a, const Vec3<D> &b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

/// v . v and a little more. What fills up fans and lines of springs may have both of its ends at one place, and what is
/// multiplied by zero there has to be finite.
template <class D> HWY_INLINE hn::Vec<D> squared_length(D d, const Vec3<D> &v) {
    const auto little = hn::Set(d, hn::TFromD<D>(1e-30));
    return hn::MulAdd(v.x, v.x, hn::MulAdd(v.y, v.y, hn::MulAdd(v.z, v.z, little)));
}

template <class D> HWY_INLINE Vec3<D> cross(const Vec3<D> &a, const Vec3<D> &b) {
    return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
            hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

template <class D> HWY_INLINE Vec3<D> scaled(hn::Vec<D> factor, const Vec3<D> &v) {
    return {hn::Mul(factor, v.x), hn::Mul(factor, v.y), hn::Mul(factor, v.z)};
}

template <class D> HWY_INLINE Vec3<D> plus(const Vec3<D> &a, const Vec3<D> &b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

template <class D> HWY_INLINE Vec3<D> minus(const Vec3<D> &a, const Vec3<D> &b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

// Strains and stresses, one to a lane.

template <class D> struct Symmetric { hn::Vec<D> xx, yy, zz, xy, yz, zx; };

/// r a + s b + t c
template <class D>
HWY_INLINE Vec3<D> combined(hn::Vec<D> r, const Vec3<D> &a, hn::Vec<D> s, const Vec3<D> &b, hn::Vec<D> t,
                            const Vec3<D> &c) {
    return {hn::MulAdd(r, a.x, hn::MulAdd(s, b.x, hn::Mul(t, c.x))),
            hn::MulAdd(r, a.y, hn::MulAdd(s, b.y, hn::Mul(t, c.y))),
            hn::MulAdd(r, a.z, hn::MulAdd(s, b.z, hn::Mul(t, c.z)))};
}

/// a + factor b
template <class D> HWY_INLINE Vec3<D> plus_scaled(const Vec3<D> &a, hn::Vec<D> factor, const Vec3<D> &b) {
    return {hn::MulAdd(factor, b.x, a.x), hn::MulAdd(factor, b.y, a.y), hn::MulAdd(factor, b.z, a.z)};
}
template <class D>
HWY_INLINE Symmetric<D> plus_scaled(const Symmetric<D> &a, hn::Vec<D> factor, const Symmetric<D> &b) {
    return {hn::MulAdd(factor, b.xx, a.xx), hn::MulAdd(factor, b.yy, a.yy), hn::MulAdd(factor, b.zz, a.zz),
            hn::MulAdd(factor, b.xy, a.xy), hn::MulAdd(factor, b.yz, a.yz), hn::MulAdd(factor, b.zx, a.zx)};
}

template <class D> HWY_INLINE Symmetric<D> plus(const Symmetric<D> &a, const Symmetric<D> &b) {
    return {hn::Add(a.xx, b.xx), hn::Add(a.yy, b.yy), hn::Add(a.zz, b.zz),
            hn::Add(a.xy, b.xy), hn::Add(a.yz, b.yz), hn::Add(a.zx, b.zx)};
}

template <class D> HWY_INLINE Symmetric<D> minus(const Symmetric<D> &a, const Symmetric<D> &b) {
    return {hn::Sub(a.xx, b.xx), hn::Sub(a.yy, b.yy), hn::Sub(a.zz, b.zz),
            hn::Sub(a.xy, b.xy), hn::Sub(a.yz, b.yz), hn::Sub(a.zx, b.zx)};
}

template <class D> HWY_INLINE Symmetric<D> scaled(hn::Vec<D> factor, const Symmetric<D> &a) {
    return {hn::Mul(factor, a.xx), hn::Mul(factor, a.yy), hn::Mul(factor, a.zz),
            hn::Mul(factor, a.xy), hn::Mul(factor, a.yz), hn::Mul(factor, a.zx)};
}

template <class D> HWY_INLINE Vec3<D> product(const Symmetric<D> &a, const Vec3<D> &v) {
    return {dot(Vec3<D>{a.xx, a.xy, a.zx}, v), dot(Vec3<D>{a.xy, a.yy, a.yz}, v), dot(Vec3<D>{a.zx, a.yz, a.zz}, v)};
}

/// Place of the first of six numbers of each of many things, in slices of shape (6, 16).
HWY_INLINE std::size_t first_of_six(std::size_t number) {
    const std::size_t lane = number % slice_size;
    return 6 * (number - lane) + lane;
}

template <class D, class T> HWY_INLINE Symmetric<D> load_six(D d, const T *at) {
    const auto load = [&](int k) HWY_ATTR { return hn::Load(d, at + k * slice_size); };
    return {load(0), load(1), load(2), load(3), load(4), load(5)};
}

template <class D, class T> HWY_INLINE void store_six(D d, const Symmetric<D> &value, T *at) {
    const auto store = [&](int k, const hn::Vec<D> &v) HWY_ATTR { hn::Store(v, d, at + k * slice_size); };
    store(0, value.xx);
    store(1, value.yy);
    store(2, value.zz);
    store(3, value.xy);
    store(4, value.yz);
    store(5, value.zx);
}

/// mu ((tr E) 1 + 2 E), as springs do.
template <class D> HWY_INLINE Symmetric<D> stress(D d, hn::Vec<D> shear_modulus, const Symmetric<D> &strain) {
    const auto twice = hn::Mul(hn::Set(d, hn::TFromD<D>(2)), shear_modulus);
    const auto mean = hn::Mul(shear_modulus, hn::Add(strain.xx, hn::Add(strain.yy, strain.zz)));
    return {hn::MulAdd(twice, strain.xx, mean), hn::MulAdd(twice, strain.yy, mean), hn::MulAdd(twice, strain.zz, mean),
            hn::Mul(twice, strain.xy),          hn::Mul(twice, strain.yz),          hn::Mul(twice, strain.zx)};
}

/// 2 mu dev E, the part of it that resists changes of shape alone.
template <class D>
HWY_INLINE Symmetric<D> deviatoric_stress(D d, hn::Vec<D> shear_modulus, const Symmetric<D> &strain) {
    using T = hn::TFromD<D>;
    const auto twice = hn::Mul(hn::Set(d, T(2)), shear_modulus);
    const auto mean = hn::Mul(hn::Set(d, T(1.0 / 3.0)), hn::Add(strain.xx, hn::Add(strain.yy, strain.zz)));
    return {hn::Mul(twice, hn::Sub(strain.xx, mean)),
            hn::Mul(twice, hn::Sub(strain.yy, mean)),
            hn::Mul(twice, hn::Sub(strain.zz, mean)),
            hn::Mul(twice, strain.xy),
            hn::Mul(twice, strain.yz),
            hn::Mul(twice, strain.zx)};
}

// Inverse square roots.

namespace hn = hwy::HWY_NAMESPACE;

/// One step of Newton's method for 1 / sqrt(v), which doubles the digits of a guess.
template <class D, class V> HWY_INLINE V refined(D d, V v, V guess) {
    using T = hn::TFromD<D>;
    const auto half = hn::Mul(v, hn::Set(d, T(0.5)));
    return hn::Mul(guess, hn::NegMulAdd(hn::Mul(half, guess), guess, hn::Set(d, T(1.5))));
}

/// 1 / sqrt(v) to half the digits at least: what one more step makes precise. The instructions that take a root and
/// divide need several times as long. Where there is no quick guess, or the numbers are to be those of another machine,
/// it is exact.
template <class D, class V> HWY_INLINE V guess_of_inverse_root(D d, V v) {
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128 || defined(LIVERMARK_EXACT_ROOTS)
    return hn::Div(hn::Set(d, hn::TFromD<D>(1)), hn::Sqrt(v));
#else
    if constexpr (sizeof(hn::TFromD<D>) == 4) {
        return hn::ApproximateReciprocalSqrt(v);
    } else {
        const hn::Rebind<float, D> narrow;
        const auto in_single = hn::DemoteTo(narrow, v);
        const auto guess = refined(narrow, in_single, hn::ApproximateReciprocalSqrt(in_single));
        return refined(d, v, hn::PromoteTo(d, guess));
    }
#endif
}

// Strains and stresses of tetrahedra in which displacements are linear.

/// Vectors of three corners of a tetrahedron: of the end of the axis (a) and of the nodes of the rim (b and c).
template <class D> struct OfCorners { Vec3<D> a, b, c; };

/// Gradients of the barycentric coordinates at rest.
/// @param t  place on the lines
template <class D, class T>
HWY_INLINE OfCorners<D> rest_gradients(D d, const SlicedBody<T> &body, std::size_t t, std::size_t lane) {
    const T *at = body.rest_gradient.data() + 9 * (t - lane) + lane;
    const auto load = [&](int k) HWY_ATTR { return hn::Load(d, at + k * slice_size); };
    return {{load(0), load(1), load(2)}, {load(3), load(4), load(5)}, {load(6), load(7), load(8)}};
}

/// The gradient of a field that is linear in a tetrahedron, or a stress of Piola's: what it makes of three directions.
template <class D> struct Columns { Vec3<D> x, y, z; };

/// @param field  less its value at the start of the axis
template <class D> HWY_INLINE Columns<D> gradient(const OfCorners<D> &field, const OfCorners<D> &rest) {
    return {combined<D>(rest.a.x, field.a, rest.b.x, field.b, rest.c.x, field.c),
            combined<D>(rest.a.y, field.a, rest.b.y, field.b, rest.c.y, field.c),
            combined<D>(rest.a.z, field.a, rest.b.z, field.b, rest.c.z, field.c)};
}

/// F^T F - 1, twice Green's strain. All six stretches of edges are in it (springs/tetrahedron.hpp), and with the
/// gradient F it takes neither lengths nor as many digits from tetrahedra that are thin.
template <class D> HWY_INLINE Symmetric<D> twice_strain(D d, const Columns<D> &f) {
    const auto one = hn::Set(d, hn::TFromD<D>(1));
    return {hn::Sub(dot(f.x, f.x), one),
            hn::Sub(dot(f.y, f.y), one),
            hn::Sub(dot(f.z, f.z), one),
            dot(f.x, f.y),
            dot(f.y, f.z),
            dot(f.z, f.x)};
}

/// F^T R + R^T F, how fast that grows where F grows by R.
template <class D> HWY_INLINE Symmetric<D> twice_strain_rate(const Columns<D> &f, const Columns<D> &rate) {
    const auto both = [](const Vec3<D> &a, const Vec3<D> &b, const Vec3<D> &rate_of_a, const Vec3<D> &rate_of_b)
                          HWY_ATTR { return hn::Add(dot(a, rate_of_b), dot(b, rate_of_a)); };
    return {both(f.x, f.x, rate.x, rate.x), both(f.y, f.y, rate.y, rate.y), both(f.z, f.z, rate.z, rate.z),
            both(f.x, f.y, rate.x, rate.y), both(f.y, f.z, rate.y, rate.z), both(f.z, f.x, rate.z, rate.x)};
}

/// lambda (tr E) 1 + 2 mu E
/// @param twice_strain  2 E
template <class D>
HWY_INLINE Symmetric<D> stress(hn::Vec<D> half_lambda, hn::Vec<D> shear_modulus, const Symmetric<D> &twice_strain) {
    const auto &[xx, yy, zz, xy, yz, zx] = twice_strain;
    const auto mean = hn::Mul(half_lambda, hn::Add(xx, hn::Add(yy, zz)));
    return {hn::MulAdd(shear_modulus, xx, mean), hn::MulAdd(shear_modulus, yy, mean),
            hn::MulAdd(shear_modulus, zz, mean), hn::Mul(shear_modulus, xy),
            hn::Mul(shear_modulus, yz),          hn::Mul(shear_modulus, zx)};
}

/// F S.
template <class D> HWY_INLINE Columns<D> product(const Columns<D> &f, const Symmetric<D> &stress) {
    return {combined<D>(stress.xx, f.x, stress.xy, f.y, stress.zx, f.z),
            combined<D>(stress.xy, f.x, stress.yy, f.y, stress.yz, f.z),
            combined<D>(stress.zx, f.x, stress.yz, f.y, stress.zz, f.z)};
}

/// Pulls of a stress on the corners inwards, P g of each.
/// @param p  first stress of Piola and Kirchhoff, times the volume
template <class D> HWY_INLINE OfCorners<D> pulls(const Columns<D> &p, const OfCorners<D> &rest) {
    const auto along = [&](const Vec3<D> &g) HWY_ATTR { return combined<D>(g.x, p.x, g.y, p.y, g.z, p.z); };
    return {along(rest.a), along(rest.b), along(rest.c)};
}

template <class D> HWY_INLINE Columns<D> plus(const Columns<D> &a, const Columns<D> &b) {
    return {plus(a.x, b.x), plus(a.y, b.y), plus(a.z, b.z)};
}
template <class D> HWY_INLINE Columns<D> minus(const Columns<D> &a, const Columns<D> &b) {
    return {minus(a.x, b.x), minus(a.y, b.y), minus(a.z, b.z)};
}
template <class D> HWY_INLINE Columns<D> scaled(hn::Vec<D> factor, const Columns<D> &a) {
    return {scaled<D>(factor, a.x), scaled<D>(factor, a.y), scaled<D>(factor, a.z)};
}

/// Parts of C = I + G, with the invariants I1, I2 and I3 of G
///   det C = 1 + I1 + I2 + I3,   C^-1 det C = (1 + I1) I - G + adj G,   (I - C^-1) det C = G - adj G + (I2 + I3) I,
/// so that small strains lose no digits.
template <class D> struct CauchyGreen {
    Symmetric<D> adjugate;               ///< of G
    hn::Vec<D> i1, two_and_three;        ///< I1, and I2 + I3
    hn::Vec<D> adjugate_trace;           ///< of C
    hn::Vec<D> exact_change, det_change; ///< det C - 1, and what it is taken for
};

/// @param twice_strain   G
/// @param least_stretch  see FastStepOptions; det C is taken as if no less than the trace of its adjugate allows
template <class D> HWY_INLINE CauchyGreen<D> cauchy_green(D d, const Symmetric<D> &twice_strain, double least_stretch) {
    using T = hn::TFromD<D>;
    const auto &[xx, yy, zz, xy, yz, zx] = twice_strain;
    const auto one = hn::Set(d, T(1));
    const Symmetric<D> adjugate{hn::MulSub(yy, zz, hn::Mul(yz, yz)), hn::MulSub(zz, xx, hn::Mul(zx, zx)),
                                hn::MulSub(xx, yy, hn::Mul(xy, xy)), hn::MulSub(zx, yz, hn::Mul(xy, zz)),
                                hn::MulSub(xy, zx, hn::Mul(yz, xx)), hn::MulSub(xy, yz, hn::Mul(zx, yy))};
    const auto i1 = hn::Add(xx, hn::Add(yy, zz));
    const auto i2 = hn::Add(adjugate.xx, hn::Add(adjugate.yy, adjugate.zz));
    const auto i3 = hn::MulAdd(xx, adjugate.xx, hn::MulAdd(xy, adjugate.xy, hn::Mul(zx, adjugate.zx)));
    const auto two_and_three = hn::Add(i2, i3);
    const double square = least_stretch * least_stretch;
    const auto least = hn::Set(d, static_cast<T>(-1.0 + std::max(1e-6, square)));
    const auto adjugate_trace = hn::MulAdd(hn::Set(d, T(2)), i1, hn::Add(i2, hn::Set(d, T(3))));
    const auto bent = hn::MulSub(hn::Set(d, static_cast<T>(square / (1.0 + 2.0 * square))), adjugate_trace, one);
    const auto exact = hn::Add(i1, two_and_three);
    return {adjugate, i1, two_and_three, adjugate_trace, exact, hn::Max(hn::Max(exact, bent), least)};
}

/// A measure g of a relative change of volume, see VolumeMeasure: g^2 and the derivatives of g^2 / 2.
template <class D> struct SquaredVolume { hn::Vec<D> square, slope, curvature; };

/// A : B
template <class D> HWY_INLINE hn::Vec<D> contraction(const Symmetric<D> &a, const Symmetric<D> &b) {
    const auto diagonal = hn::MulAdd(a.xx, b.xx, hn::MulAdd(a.yy, b.yy, hn::Mul(a.zz, b.zz)));
    const auto beside = hn::MulAdd(a.xy, b.xy, hn::MulAdd(a.yz, b.yz, hn::Mul(a.zx, b.zx)));
    return hn::Add(diagonal, hn::Add(beside, beside));
}

/// A + factor I
template <class D> HWY_INLINE Symmetric<D> plus_identity(Symmetric<D> a, hn::Vec<D> factor) {
    a.xx = hn::Add(a.xx, factor);
    a.yy = hn::Add(a.yy, factor);
    a.zz = hn::Add(a.zz, factor);
    return a;
}

/// A B A
template <class D> HWY_INLINE Symmetric<D> sandwich(const Symmetric<D> &a, const Symmetric<D> &b) {
    const Vec3<D> x{a.xx, a.xy, a.zx}, y{a.xy, a.yy, a.yz}, z{a.zx, a.yz, a.zz};
    const auto b_x = product<D>(b, x), b_y = product<D>(b, y), b_z = product<D>(b, z);
    return {dot(x, b_x), dot(y, b_y), dot(z, b_z), dot(x, b_y), dot(y, b_z), dot(z, b_x)};
}

/// Stress of mu / 2 (J^-2/3 tr C - 3), mu J^-2/3 (I - tr C / 3 C^-1), where
///   (I - tr C / 3 C^-1) det C = (1 + I1 / 3) (G - adj G) + (I2 + I3 - I1 (1 + I1) / 3) I.
template <class D>
HWY_INLINE Symmetric<D> isochoric_stress(D d, hn::Vec<D> shear_modulus, const Symmetric<D> &twice_strain,
                                         const CauchyGreen<D> &of) {
    using T = hn::TFromD<D>;
    const auto one = hn::Set(d, T(1)), third = hn::Set(d, T(1.0 / 3.0));
    const auto isochoric = hn::Exp(d, hn::Mul(hn::Set(d, T(-1.0 / 3.0)), hn::Log1p(d, of.det_change)));
    const auto scale = hn::Div(hn::Mul(shear_modulus, isochoric), hn::Add(one, of.det_change));
    const auto part = hn::Mul(scale, hn::MulAdd(third, of.i1, one));
    const auto mean = hn::Mul(scale, hn::NegMulAdd(hn::Mul(third, of.i1), hn::Add(one, of.i1), of.two_and_three));
    return plus_identity<D>(scaled<D>(part, minus<D>(twice_strain, of.adjugate)), mean);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_VECTORS_INL_HPP
