#pragma once
// Stands for Highway where kernels are to count what they do: vectors of 64 bytes, each of whose operations is counted.
// It has what the kernels of msm/ and interactive/ take from Highway, and steps in single precision alone.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "benchmarks/work/counts.hpp"

#define HWY_NAMESPACE N_COUNTING
#define HWY_SCALAR 1
#define HWY_EMU128 2
#define HWY_AVX3 3
#define HWY_TARGET 4 // has none of the ways of their own that kernels have for those above
#define HWY_ONCE 1
#define HWY_HAVE_FLOAT64 0
#define HWY_INLINE inline __attribute__((always_inline))
#define HWY_NOINLINE __attribute__((noinline))
#define HWY_ATTR
#define HWY_ALIGN alignas(64)
#define HWY_RESTRICT __restrict__
#define HWY_LIKELY(condition) (condition)
#define HWY_BEFORE_NAMESPACE() static_assert(true)
#define HWY_AFTER_NAMESPACE() static_assert(true)
#define HWY_EXPORT(function) static_assert(true)
#define HWY_DYNAMIC_DISPATCH(function) HWY_NAMESPACE::function

namespace hwy::HWY_NAMESPACE {

template <class T, std::size_t N> struct Tag {
    using Number = T;
    static constexpr std::size_t num_lanes = N;
};
/// Of the compiler: GCC and Clang compute with such arrays.
template <class T, std::size_t N> struct Many {
    typedef T Array __attribute__((vector_size(N * sizeof(T))));
    Array raw;
};
template <std::size_t N> struct Truths { std::array<bool, N> raw; };

template <class T, std::size_t N> using CappedTag = Tag<T, (N * sizeof(T) < 64 ? N : 64 / sizeof(T))>;
template <class T> using Full128 = Tag<T, 16 / sizeof(T)>;
template <class D> using TFromD = typename D::Number;
template <class D> using Vec = Many<TFromD<D>, D::num_lanes>;
template <class D> using Mask = Truths<D::num_lanes>;
template <class D> using Half = Tag<TFromD<D>, D::num_lanes / 2>;
template <class T, class D> using Rebind = Tag<T, D::num_lanes>;
template <class D> using RebindToSigned = Tag<std::int32_t, D::num_lanes>;
template <class D> using RebindToUnsigned = Tag<std::uint32_t, D::num_lanes>;
template <class D> using RepartitionToWide = Tag<std::uint64_t, D::num_lanes / 2>;

template <class D> constexpr std::size_t Lanes(D) {
    return D::num_lanes;
}
template <class D> constexpr std::size_t MaxLanes(D) {
    return D::num_lanes;
}

/// Of each lane, of floats alone.
template <class T, std::size_t N> HWY_INLINE void count(int operations) {
    if constexpr (std::is_floating_point_v<T>)
        livermark::benchmarks::count_operations(operations * static_cast<int>(N));
}
/// @param value  of a lane
template <class D, class Value> HWY_INLINE Vec<D> lane_by_lane(const Value &value) {
    Vec<D> result;
    for (std::size_t i = 0; i < D::num_lanes; ++i)
        result.raw[i] = static_cast<TFromD<D>>(value(i));
    return result;
}
template <std::size_t N, class Value> HWY_INLINE Truths<N> truth_by_lane(const Value &value) {
    Truths<N> result;
    for (std::size_t i = 0; i < N; ++i)
        result.raw[i] = value(i);
    return result;
}

// Memory.
template <class D> HWY_INLINE Vec<D> Set(D, TFromD<D> value) {
    return lane_by_lane<D>([&](std::size_t) { return value; });
}
template <class D> HWY_INLINE Vec<D> Zero(D) {
    return Vec<D>{};
}
/// One by one, since the compiler does not report what it copies at once.
template <class D, class T> HWY_INLINE Vec<D> Load(D, const T *at) {
    return lane_by_lane<D>([&](std::size_t i) { return at[i]; });
}
template <class D, class T> HWY_INLINE Vec<D> LoadU(D d, const T *at) {
    return Load(d, at);
}
template <class D, class T> HWY_INLINE void Store(Vec<D> v, D, T *at) {
    for (std::size_t i = 0; i < D::num_lanes; ++i)
        at[i] = v.raw[i];
}
template <class D, class T> HWY_INLINE void StoreU(Vec<D> v, D d, T *at) {
    Store(v, d, at);
}
template <class D, class T>
HWY_INLINE void LoadInterleaved4(D, const T *at, Vec<D> &x, Vec<D> &y, Vec<D> &z, Vec<D> &w) {
    for (std::size_t i = 0; i < D::num_lanes; ++i) {
        x.raw[i] = at[4 * i];
        y.raw[i] = at[4 * i + 1];
        z.raw[i] = at[4 * i + 2];
        w.raw[i] = at[4 * i + 3];
    }
}
template <class D, class T> HWY_INLINE void StoreInterleaved4(Vec<D> x, Vec<D> y, Vec<D> z, Vec<D> w, D, T *at) {
    for (std::size_t i = 0; i < D::num_lanes; ++i) {
        at[4 * i] = x.raw[i];
        at[4 * i + 1] = y.raw[i];
        at[4 * i + 2] = z.raw[i];
        at[4 * i + 3] = w.raw[i];
    }
}
template <class D, class T, std::size_t N>
HWY_INLINE Vec<D> GatherIndex(D, const T *base, Many<std::int32_t, N> index) {
    return lane_by_lane<D>([&](std::size_t i) { return base[index.raw[i]]; });
}

// Between lanes.
template <class T, std::size_t N> HWY_INLINE T GetLane(Many<T, N> v) {
    return v.raw[0];
}
template <class D> HWY_INLINE Vec<D> MaxOfLanes(D d, Vec<D> v) {
    auto largest = v.raw[0];
    for (std::size_t i = 1; i < D::num_lanes; ++i)
        largest = v.raw[i] > largest ? v.raw[i] : largest;
    return Set(d, largest);
}
template <class D> HWY_INLINE Vec<D> Combine(D, Vec<Half<D>> upper, Vec<Half<D>> lower) {
    constexpr std::size_t half = D::num_lanes / 2;
    return lane_by_lane<D>([&](std::size_t i) { return i < half ? lower.raw[i] : upper.raw[i - half]; });
}
template <class D, class T, std::size_t N> HWY_INLINE Vec<D> LowerHalf(D, Many<T, N> v) {
    return lane_by_lane<D>([&](std::size_t i) { return v.raw[i]; });
}
template <class D, class T, std::size_t N> HWY_INLINE Vec<D> UpperHalf(D, Many<T, N> v) {
    return lane_by_lane<D>([&](std::size_t i) { return v.raw[i + N / 2]; });
}
/// Within blocks of 16 bytes.
template <class D> HWY_INLINE Vec<D> interleaved(Vec<D> a, Vec<D> b, std::size_t first) {
    constexpr std::size_t block = 16 / sizeof(TFromD<D>);
    return lane_by_lane<D>([&](std::size_t i) {
        const std::size_t from = i / block * block + first + i % block / 2;
        return i % 2 == 0 ? a.raw[from] : b.raw[from];
    });
}
template <class D> HWY_INLINE Vec<D> InterleaveLower(D, Vec<D> a, Vec<D> b) {
    return interleaved<D>(a, b, 0);
}
template <class D> HWY_INLINE Vec<D> InterleaveUpper(D, Vec<D> a, Vec<D> b) {
    return interleaved<D>(a, b, 8 / sizeof(TFromD<D>));
}
template <class D, class T, std::size_t N> HWY_INLINE Vec<D> BitCast(D, Many<T, N> a) {
    return std::bit_cast<Vec<D>>(a);
}
template <class D, class T, std::size_t N> HWY_INLINE Vec<D> ConvertTo(D, Many<T, N> a) {
    return lane_by_lane<D>([&](std::size_t i) { return a.raw[i]; });
}
template <class D, class T, std::size_t N> HWY_INLINE Vec<D> PromoteTo(D d, Many<T, N> a) {
    return ConvertTo(d, a);
}
template <class D, class T, std::size_t N> HWY_INLINE Vec<D> DemoteTo(D d, Many<T, N> a) {
    return ConvertTo(d, a);
}

// Arithmetic.
template <class T, std::size_t N> HWY_INLINE Many<T, N> Add(Many<T, N> a, Many<T, N> b) {
    count<T, N>(1);
    return {a.raw + b.raw};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Sub(Many<T, N> a, Many<T, N> b) {
    count<T, N>(1);
    return {a.raw - b.raw};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Mul(Many<T, N> a, Many<T, N> b) {
    count<T, N>(1);
    return {a.raw * b.raw};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Div(Many<T, N> a, Many<T, N> b) {
    count<T, N>(1);
    return {a.raw / b.raw};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> MulAdd(Many<T, N> a, Many<T, N> b, Many<T, N> c) {
    count<T, N>(2);
    return {a.raw * b.raw + c.raw};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> MulSub(Many<T, N> a, Many<T, N> b, Many<T, N> c) {
    count<T, N>(2);
    return {a.raw * b.raw - c.raw};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> NegMulAdd(Many<T, N> a, Many<T, N> b, Many<T, N> c) {
    count<T, N>(2);
    return {c.raw - a.raw * b.raw};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Neg(Many<T, N> a) {
    return {-a.raw};
}
template <int bits, class T, std::size_t N> HWY_INLINE Many<T, N> ShiftRight(Many<T, N> a) {
    return {a.raw >> bits};
}
template <int bits, class T, std::size_t N> HWY_INLINE Many<T, N> ShiftLeft(Many<T, N> a) {
    return {a.raw << bits};
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Max(Many<T, N> a, Many<T, N> b) {
    return lane_by_lane<Tag<T, N>>([&](std::size_t i) { return a.raw[i] > b.raw[i] ? a.raw[i] : b.raw[i]; });
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Min(Many<T, N> a, Many<T, N> b) {
    return lane_by_lane<Tag<T, N>>([&](std::size_t i) { return a.raw[i] < b.raw[i] ? a.raw[i] : b.raw[i]; });
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Abs(Many<T, N> a) {
    return lane_by_lane<Tag<T, N>>([&](std::size_t i) { return std::abs(a.raw[i]); });
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> CopySignToAbs(Many<T, N> a, Many<T, N> sign) {
    return lane_by_lane<Tag<T, N>>([&](std::size_t i) { return std::copysign(a.raw[i], sign.raw[i]); });
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> Sqrt(Many<T, N> a) {
    count<T, N>(1);
    return lane_by_lane<Tag<T, N>>([&](std::size_t i) { return std::sqrt(a.raw[i]); });
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> ApproximateReciprocalSqrt(Many<T, N> a) {
    count<T, N>(1);
    return lane_by_lane<Tag<T, N>>([&](std::size_t i) { return T(1) / std::sqrt(a.raw[i]); });
}

// Choices.
template <class T, std::size_t N> HWY_INLINE Truths<N> Gt(Many<T, N> a, Many<T, N> b) {
    return truth_by_lane<N>([&](std::size_t i) { return a.raw[i] > b.raw[i]; });
}
template <class T, std::size_t N> HWY_INLINE Truths<N> Ge(Many<T, N> a, Many<T, N> b) {
    return truth_by_lane<N>([&](std::size_t i) { return a.raw[i] >= b.raw[i]; });
}
template <class T, std::size_t N> HWY_INLINE Truths<N> Lt(Many<T, N> a, Many<T, N> b) {
    return Gt(b, a);
}
template <class T, std::size_t N> HWY_INLINE Truths<N> Eq(Many<T, N> a, Many<T, N> b) {
    return truth_by_lane<N>([&](std::size_t i) { return a.raw[i] == b.raw[i]; });
}
template <std::size_t N> HWY_INLINE Truths<N> And(Truths<N> a, Truths<N> b) {
    return truth_by_lane<N>([&](std::size_t i) { return a.raw[i] && b.raw[i]; });
}
template <std::size_t N> HWY_INLINE Truths<N> Or(Truths<N> a, Truths<N> b) {
    return truth_by_lane<N>([&](std::size_t i) { return a.raw[i] || b.raw[i]; });
}
template <std::size_t N> HWY_INLINE Truths<N> Not(Truths<N> a) {
    return truth_by_lane<N>([&](std::size_t i) { return !a.raw[i]; });
}
template <std::size_t N> HWY_INLINE Truths<N> AndNot(Truths<N> a, Truths<N> b) {
    return And(Not(a), b);
}
template <class D> HWY_INLINE bool AllTrue(D, Mask<D> a) {
    bool all = true;
    for (const bool each : a.raw)
        all = all && each;
    return all;
}
template <class D> HWY_INLINE bool AllFalse(D d, Mask<D> a) {
    return AllTrue(d, Not(a));
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> IfThenElse(Truths<N> choice, Many<T, N> a, Many<T, N> b) {
    return lane_by_lane<Tag<T, N>>([&](std::size_t i) { return choice.raw[i] ? a.raw[i] : b.raw[i]; });
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> IfThenElseZero(Truths<N> choice, Many<T, N> a) {
    return IfThenElse(choice, a, Many<T, N>{});
}
template <class T, std::size_t N> HWY_INLINE Many<T, N> IfThenZeroElse(Truths<N> choice, Many<T, N> a) {
    return IfThenElse(choice, Many<T, N>{}, a);
}

// As many operations as those of Highway 1.0 have in single precision (hwy/contrib/math/math-inl.h).
template <class D> HWY_INLINE Vec<D> Log(D, Vec<D> a) {
    count<TFromD<D>, D::num_lanes>(20);
    return lane_by_lane<D>([&](std::size_t i) { return std::log(a.raw[i]); });
}
template <class D> HWY_INLINE Vec<D> Log1p(D, Vec<D> a) {
    count<TFromD<D>, D::num_lanes>(23);
    return lane_by_lane<D>([&](std::size_t i) { return std::log1p(a.raw[i]); });
}
template <class D> HWY_INLINE Vec<D> Exp(D, Vec<D> a) {
    count<TFromD<D>, D::num_lanes>(24);
    return lane_by_lane<D>([&](std::size_t i) { return std::exp(a.raw[i]); });
}

} // namespace hwy::HWY_NAMESPACE
