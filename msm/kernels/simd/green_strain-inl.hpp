// Gradient, strain and stress of tetrahedra in which displacements are linear. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_GREEN_STRAIN_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_GREEN_STRAIN_INL_HPP
#undef LIVERMARK_GREEN_STRAIN_INL_HPP
#else
#define LIVERMARK_GREEN_STRAIN_INL_HPP
#endif

#include "msm/kernels/simd/stressed_fans-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// The gradient of a field that is linear in a tetrahedron, or a stress of Piola's: what it makes of three directions.
template <class D> struct Columns { Vec3<D> x, y, z; };

/// @param field  less its value at the start of the axis
template <class D> HWY_INLINE Columns<D> gradient(const OfCorners<D> &field, const OfCorners<D> &rest) {
    return {combined<D>(rest.a.x, field.a, rest.b.x, field.b, rest.c.x, field.c),
            combined<D>(rest.a.y, field.a, rest.b.y, field.b, rest.c.y, field.c),
            combined<D>(rest.a.z, field.a, rest.b.z, field.b, rest.c.z, field.c)};
}

/// F^T F - 1, twice Green's strain. All six stretches of edges are in it (linear_elements.hpp), and with the
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

/// What a stress pulls the corners inwards with, P g of each.
/// @param p  first stress of Piola and Kirchhoff, times the volume
template <class D> HWY_INLINE OfCorners<D> pulls(const Columns<D> &p, const OfCorners<D> &rest) {
    const auto along = [&](const Vec3<D> &g) HWY_ATTR { return combined<D>(g.x, p.x, g.y, p.y, g.z, p.z); };
    return {along(rest.a), along(rest.b), along(rest.c)};
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_GREEN_STRAIN_INL_HPP
