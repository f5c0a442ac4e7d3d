// Symmetric matrices of three rows, one to a lane. Written once for each vector unit: see explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_SYMMETRIC_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_SYMMETRIC_INL_HPP
#undef LIVERMARK_INTERACTIVE_SYMMETRIC_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_SYMMETRIC_INL_HPP
#endif

#include "interactive/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

struct Symmetric {
    V xx, xy, xz, yy, yz, zz;
};

/// Of a matrix A its inverse times det A, and det A.
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

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_SYMMETRIC_INL_HPP
