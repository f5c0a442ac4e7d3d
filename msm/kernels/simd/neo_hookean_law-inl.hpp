// The neo-Hookean law of springs and volumes. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_NEO_HOOKEAN_LAW_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_NEO_HOOKEAN_LAW_INL_HPP
#undef LIVERMARK_NEO_HOOKEAN_LAW_INL_HPP
#else
#define LIVERMARK_NEO_HOOKEAN_LAW_INL_HPP
#endif

#include <algorithm>
#include <cmath>
#include <hwy/contrib/math/math-inl.h>

#include "msm/kernels/simd/fan_forces-inl.hpp"
#include "msm/kernels/simd/stressed_fans-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Of C = I + G, with the invariants I1, I2 and I3 of G
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

/// S = mu (I - C^-1 + 1/2 ln det C C^-1)
/// @param twice_strain, least_stretch  see cauchy_green()
/// @param largest  told how much det C lacks of what makes the trace of C^-1 four
template <class D>
HWY_INLINE Symmetric<D> neo_hookean_stress(D d, hn::Vec<D> shear_modulus, const Symmetric<D> &twice_strain,
                                           double least_stretch, LargestDeficit<D> &largest) {
    using T = hn::TFromD<D>;
    const auto &[xx, yy, zz, xy, yz, zx] = twice_strain;
    const auto [adjugate, i1, two_and_three, adjugate_trace, exact, change] =
        cauchy_green(d, twice_strain, least_stretch);
    const auto one = hn::Set(d, T(1));
    largest.deficit = hn::Max(largest.deficit, hn::Sub(hn::MulSub(hn::Set(d, T(0.25)), adjugate_trace, one), exact));
    const auto half_log = hn::Mul(hn::Set(d, T(0.5)), hn::Log1p(d, change));
    const auto scale = hn::Div(shear_modulus, hn::Add(one, change));
    const auto part = hn::Mul(scale, hn::Sub(one, half_log));
    const auto mean = hn::Mul(scale, hn::MulAdd(half_log, hn::Add(one, i1), two_and_three));
    const auto along = [&](const hn::Vec<D> &g, const hn::Vec<D> &a) HWY_ATTR { return hn::Mul(part, hn::Sub(g, a)); };
    const auto diagonal = [&](const hn::Vec<D> &g, const hn::Vec<D> &a)
                              HWY_ATTR { return hn::MulAdd(part, hn::Sub(g, a), mean); };
    return {diagonal(xx, adjugate.xx), diagonal(yy, adjugate.yy), diagonal(zz, adjugate.zz),
            along(xy, adjugate.xy),    along(yz, adjugate.yz),    along(zx, adjugate.zx)};
}

/// The part of it that resists changes of shape alone, mu J^-2/3 (I - tr C / 3 C^-1), where
///   (I - tr C / 3 C^-1) det C = (1 + I1 / 3) (G - adj G) + (I2 + I3 - I1 (1 + I1) / 3) I.
template <class D>
HWY_INLINE Symmetric<D> isochoric_stress(D d, hn::Vec<D> shear_modulus, const Symmetric<D> &twice_strain,
                                         double least_stretch) {
    using T = hn::TFromD<D>;
    const auto of = cauchy_green(d, twice_strain, least_stretch);
    const auto one = hn::Set(d, T(1)), third = hn::Set(d, T(1.0 / 3.0));
    const auto isochoric = hn::Exp(d, hn::Mul(hn::Set(d, T(-1.0 / 3.0)), hn::Log1p(d, of.det_change)));
    const auto scale = hn::Div(hn::Mul(shear_modulus, isochoric), hn::Add(one, of.det_change));
    const auto part = hn::Mul(scale, hn::MulAdd(third, of.i1, one));
    const auto mean = hn::Mul(scale, hn::NegMulAdd(hn::Mul(third, of.i1), hn::Add(one, of.i1), of.two_and_three));
    auto stress = scaled<D>(part, minus<D>(twice_strain, of.adjugate));
    stress.xx = hn::Add(stress.xx, mean);
    stress.yy = hn::Add(stress.yy, mean);
    stress.zz = hn::Add(stress.zz, mean);
    return stress;
}

/// g g' of relative changes e of volumes, for g = ln (1 + e).
template <class D> HWY_INLINE hn::Vec<D> logarithmic_push(D d, hn::Vec<D> change, double least_stretch) {
    using T = hn::TFromD<D>;
    const auto e = hn::Max(change, hn::Set(d, static_cast<T>(-1.0 + std::max(1e-6, std::sqrt(least_stretch)))));
    return hn::Div(hn::Log1p(d, e), hn::Add(hn::Set(d, T(1)), e));
}

/// Puts down a sixth of what pushes the corners of tetrahedra outwards because of their volume: the guard, and springs
/// inside, whose S = mu (I - C^-1 + ln J C^-1) is mu F + mu (ln J - 1) / J cof F in the forces V0 P g of corners, where
/// V0 cof F g is the gradient of the volume.
/// @param volume   six times the volume
/// @param t        place on the lines
/// @param largest  told what the guard sees
template <class D, class T>
HWY_INLINE void put_push_inside(D d, StepWorkspace<T> &at, hn::Vec<D> volume, std::size_t t,
                                LargestDeficit<D> &largest) {
    const auto &body = at.body;
    const auto one = hn::Set(d, T(1)), sixth = hn::Set(d, T(1.0 / 6.0));
    const auto least = hn::Set(d, static_cast<T>(std::max(1e-12, at.least_stretch * at.least_stretch)));
    // What fills up a fan has no volume.
    const auto rest_volume = hn::Max(hn::Load(d, body.rest_volume.data() + t), hn::Set(d, T(1e-30)));
    const auto j = hn::Div(hn::Mul(volume, sixth), rest_volume);
    const auto square = hn::Max(hn::Mul(j, j), least);
    const auto log = hn::Mul(hn::Set(d, T(0.5)), hn::Log(d, square));
    // (1 - ln J) / J, with the sign of J
    const auto of_springs = hn::Mul(hn::Sub(one, log), hn::Div(j, square));
    const auto push = hn::MulAdd(hn::Load(d, body.volume_modulus.data() + t), of_springs,
                                 push_of_volume(d, body, volume, volume, t, largest));
    hn::Store(hn::Mul(sixth, push), d, at.push.data() + t);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_NEO_HOOKEAN_LAW_INL_HPP
