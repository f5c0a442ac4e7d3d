// Vectors of float64 for what moves the nodes. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_DOUBLES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_DOUBLES_INL_HPP
#undef LIVERMARK_DOUBLES_INL_HPP
#else
#define LIVERMARK_DOUBLES_INL_HPP
#endif

#include <cstring>
#include <hwy/highway.h>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_HAVE_FLOAT64

namespace dn = hn;
using Doubles = hn::CappedTag<double, 8>;
using DoubleVec = hn::Vec<Doubles>;

/// Forces of either precision, as doubles.
HWY_INLINE DoubleVec as_double(const double *force) {
    return hn::Load(Doubles(), force);
}
HWY_INLINE DoubleVec as_double(const float *force) {
    return hn::PromoteTo(Doubles(), hn::Load(hn::Rebind<float, Doubles>(), force));
}

HWY_INLINE void store_as(DoubleVec v, double *place) {
    hn::Store(v, Doubles(), place);
}
HWY_INLINE void store_as(DoubleVec v, float *place) {
    const hn::Rebind<float, Doubles> narrow;
    hn::Store(hn::DemoteTo(narrow, v), narrow, place);
}

/// How many vectors of doubles it takes to hold one of D.
template <class D> constexpr std::size_t num_parts() {
    return hn::MaxLanes(D()) / hn::MaxLanes(Doubles());
}

/// A vector of either precision as doubles, and back. It stays in registers: what is stored in parts and loaded as a
/// whole has to wait until it has arrived in the cache.
template <class D, class V> HWY_INLINE void to_doubles(D /*d*/, V v, DoubleVec *parts) {
    if constexpr (std::is_same_v<hn::TFromD<D>, double>) {
        parts[0] = v;
    } else {
#if HWY_TARGET == HWY_SCALAR
        parts[0] = hn::PromoteTo(Doubles(), v);
#else
        constexpr hn::Half<D> half;
        parts[0] = hn::PromoteTo(Doubles(), hn::LowerHalf(half, v));
        parts[1] = hn::PromoteTo(Doubles(), hn::UpperHalf(half, v));
#endif
    }
}
template <class D> HWY_INLINE hn::Vec<D> from_doubles([[maybe_unused]] D d, const DoubleVec *parts) {
    if constexpr (std::is_same_v<hn::TFromD<D>, double>) {
        return parts[0];
    } else {
#if HWY_TARGET == HWY_SCALAR
        return hn::DemoteTo(d, parts[0]);
#else
        constexpr hn::Half<D> half;
        return hn::Combine(d, hn::DemoteTo(half, parts[1]), hn::DemoteTo(half, parts[0]));
#endif
    }
}

#else

/// This Highway has no vectors of float64 for WebAssembly, which has them: the same names for those of the compiler.
namespace dn {

struct Doubles {};
using DoubleVec = double __attribute__((vector_size(16)));

constexpr std::size_t Lanes(Doubles /*d*/) {
    return sizeof(DoubleVec) / sizeof(double);
}
HWY_INLINE DoubleVec Set(Doubles /*d*/, double value) {
    return DoubleVec{value, value};
}
HWY_INLINE DoubleVec Zero(Doubles d) {
    return Set(d, 0.0);
}
HWY_INLINE DoubleVec Load(Doubles /*d*/, const double *place) {
    DoubleVec v;
    std::memcpy(&v, place, sizeof v);
    return v;
}
HWY_INLINE void Store(DoubleVec v, Doubles /*d*/, double *place) {
    std::memcpy(place, &v, sizeof v);
}
HWY_INLINE DoubleVec Add(DoubleVec a, DoubleVec b) {
    return a + b;
}
HWY_INLINE DoubleVec Mul(DoubleVec a, DoubleVec b) {
    return a * b;
}
HWY_INLINE DoubleVec MulAdd(DoubleVec a, DoubleVec b, DoubleVec c) {
    return a * b + c;
}
HWY_INLINE DoubleVec NegMulAdd(DoubleVec a, DoubleVec b, DoubleVec c) {
    return c - a * b;
}

} // namespace dn

using dn::Doubles;
using dn::DoubleVec;

HWY_INLINE DoubleVec as_double(const float *force) {
    return DoubleVec{force[0], force[1]};
}
HWY_INLINE void store_as(DoubleVec v, float *place) {
    place[0] = static_cast<float>(v[0]);
    place[1] = static_cast<float>(v[1]);
}

template <class D> constexpr std::size_t num_parts() {
    return hn::MaxLanes(D()) / 2;
}
template <class D, class V> HWY_INLINE void to_doubles(D d, V v, DoubleVec *parts) {
    HWY_ALIGN float lanes[hn::MaxLanes(D())];
    hn::Store(v, d, lanes);
    for (std::size_t p = 0; p < num_parts<D>(); ++p)
        parts[p] = as_double(lanes + 2 * p);
}
template <class D> HWY_INLINE hn::Vec<D> from_doubles(D d, const DoubleVec *parts) {
    HWY_ALIGN float lanes[hn::MaxLanes(D())];
    for (std::size_t p = 0; p < num_parts<D>(); ++p)
        store_as(parts[p], lanes + 2 * p);
    return hn::Load(d, lanes);
}

#endif

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_DOUBLES_INL_HPP
