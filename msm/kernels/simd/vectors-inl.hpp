// Vectors in space, one to a lane. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_VECTORS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_VECTORS_INL_HPP
#undef LIVERMARK_VECTORS_INL_HPP
#else
#define LIVERMARK_VECTORS_INL_HPP
#endif

#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/simd/fetch-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

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

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_VECTORS_INL_HPP
