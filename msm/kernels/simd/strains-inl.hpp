// Strains and stresses of tetrahedra in which displacements are linear. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_STRAINS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_STRAINS_INL_HPP
#undef LIVERMARK_STRAINS_INL_HPP
#else
#define LIVERMARK_STRAINS_INL_HPP
#endif

#include <algorithm>
#include <hwy/contrib/math/math-inl.h>

#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

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

#endif // LIVERMARK_STRAINS_INL_HPP
