// Strains and stresses, one to a lane. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_SYMMETRIC_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_SYMMETRIC_INL_HPP
#undef LIVERMARK_SYMMETRIC_INL_HPP
#else
#define LIVERMARK_SYMMETRIC_INL_HPP
#endif

#include "msm/kernels/simd/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

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

/// Where the first of six numbers of each of many things stands, in slices of shape (6, 16).
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

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_SYMMETRIC_INL_HPP
