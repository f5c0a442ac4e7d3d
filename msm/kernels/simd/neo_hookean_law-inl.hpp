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
#include "msm/kernels/threads/thread_pool.hpp"

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

// Volumes that fans of tetrahedra gain.

/// Volume that the tetrahedra at each corner of the fans of a slice have gained, and beta times how fast they do.
/// @tparam has_energy  whether there are neo-Hookean springs with means of F: then rates stay apart, and the push of
/// what
///                     springs inside do is put down
template <bool is_damped, bool has_energy, class T>
HWY_NOINLINE void volume_gains(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto axis = fetch_axis(D(), rows, corner);
        FanRates<is_damped, D> rates;
        rates.begin(d, at, now, corner);
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        CornerSum<D> gains{D()};
        [[maybe_unused]] CornerSum<D> growth{D()};
        std::size_t rim = lines.corner + 2 * slice_size;
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto share = hn::Load(d, body.volume_share.data() + t);
            auto volume = hn::Mul(share, volume_between<is_damped>(D(), at, now, from, to, corner, rates));
            if constexpr (is_damped && has_energy) {
                const auto plain = hn::Mul(share, dot(from.lever, to.arm));
                growth.add(D(), hn::Mul(hn::Sub(volume, plain), sixth), at.gain_rate.data() + rim);
                volume = plain;
            }
            if constexpr (has_energy)
                put_push_inside(D(), at, volume, t, largest);
            gains.add(D(), hn::MulSub(volume, sixth, hn::Load(d, body.rest_volume.data() + t)), at.gain.data() + rim);
            from = to;
        }
        gains.finish(D(), at.gain.data() + lines.corner, at.gain.data() + rim);
        if constexpr (is_damped && has_energy)
            growth.finish(D(), at.gain_rate.data() + lines.corner, at.gain_rate.data() + rim);
    }
    if constexpr (has_energy)
        largest.keep(D(), at, slice);
}

// Pressures around nodes from means of changes of volume.

/// Relative changes of control volumes of a slice, from what the corners of fans there have gained.
/// @param values  of each corner
template <class T>
HWY_INLINE void put_changes(const StepWorkspace<T> &at, const Aligned<T> &values, int slice, Aligned<T> &changes) {
    using D = Lanes<T>;
    constexpr D d;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const std::size_t first = static_cast<std::size_t>(slice) * slice_size + lane;
        hn::Store(hn::Mul(hn::Load(d, at.body.inverse_volume.data() + first),
                          sum_at_corners(D(), at.body, values, slice, lane)),
                  d, changes.data() + first);
    }
}

/// Of control volumes of a slice, those from `lane` on, the means over the corners of tetrahedra around.
/// @param values  of each control volume
template <class D, class T>
HWY_INLINE hn::Vec<D> mean_around(D d, const SlicedBody<T> &body, const Aligned<T> &values, int slice,
                                  std::size_t lane) {
    const std::size_t first = static_cast<std::size_t>(body.mean_start[slice]) * slice_size + lane;
    const std::size_t end = static_cast<std::size_t>(body.mean_start[slice + 1]) * slice_size;
    HWY_ALIGN T sums[hn::MaxLanes(D())];
    // As sum_at_corners() does, and two lines at once. More numbers at once are no better: then the compiler takes the
    // machine's gather.
    constexpr std::size_t at_once = hn::MaxLanes(D()) < 4 ? hn::MaxLanes(D()) : 4;
    for (std::size_t i = 0; i < hn::Lanes(d); i += at_once) {
        T even[at_once] = {}, odd[at_once] = {};
        const auto add = [&](T *sum, std::size_t m) HWY_ATTR {
            for (std::size_t k = 0; k < at_once; ++k)
                sum[k] += body.mean_weight[m + k] * values[static_cast<std::size_t>(body.mean_volume[m + k])];
        };
        std::size_t m = first + i;
        for (; m + slice_size < end; m += 2 * slice_size) {
            add(even, m);
            add(odd, m + slice_size);
        }
        if (m < end)
            add(even, m);
        for (std::size_t k = 0; k < at_once; ++k)
            sums[i + k] = even[k] + odd[k];
    }
    const auto own = hn::Load(d, values.data() + static_cast<std::size_t>(slice) * slice_size + lane);
    return hn::MulAdd(hn::Set(d, T(0.25)), own, hn::Load(d, sums));
}

/// A quarter of the pressures of control volumes that resist the means of what they and their neighbours gain: the same
/// means are taken of g g' of these. All threads call it.
/// @param slices  of control volumes, of this thread
template <bool is_damped, class T>
HWY_NOINLINE void mean_pressures(StepWorkspace<T> &at, int now, const Partition &slices, Barrier &barrier) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    if (body.volume_stiffness.empty())
        return;
    for (int slice = slices.first; slice < slices.last; ++slice) {
        put_changes(at, at.gain, slice, at.change);
        if constexpr (is_damped)
            put_changes(at, at.gain_rate, slice, at.change_rate);
    }
    barrier.wait();
    for (int slice = slices.first; slice < slices.last; ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::size_t first = static_cast<std::size_t>(slice) * slice_size + lane;
            auto push = logarithmic_push(D(), mean_around(D(), body, at.change, slice, lane), at.least_stretch);
            if constexpr (is_damped)
                push = hn::Add(push, mean_around(D(), body, at.change_rate, slice, lane));
            hn::Store(hn::Mul(hn::Load(d, body.volume_stiffness.data() + first), push), d, at.mean_push.data() + first);
        }
    barrier.wait();
    for (int slice = slices.first; slice < slices.last; ++slice) {
        HWY_ALIGN T pressure[slice_size];
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d))
            hn::Store(mean_around(D(), body, at.mean_push, slice, lane), d, pressure + lane);
        set_pressures(at, now, slice, pressure);
    }
    barrier.wait();
}

// Energies of coupled springs with their first and second derivatives.

/// A measure g of a relative change of volume, see VolumeMeasure: g^2 and the derivatives of g^2 / 2.
template <class D> struct SquaredVolume { hn::Vec<D> square, slope, curvature; };

/// A : B
template <class D> HWY_INLINE hn::Vec<D> contraction(const Symmetric<D> &a, const Symmetric<D> &b) {
    const auto diagonal = hn::MulAdd(a.xx, b.xx, hn::MulAdd(a.yy, b.yy, hn::Mul(a.zz, b.zz)));
    const auto beside = hn::MulAdd(a.xy, b.xy, hn::MulAdd(a.yz, b.yz, hn::Mul(a.zx, b.zx)));
    return hn::Add(diagonal, hn::Add(beside, beside));
}

/// A B A
template <class D> HWY_INLINE Symmetric<D> sandwich(const Symmetric<D> &a, const Symmetric<D> &b) {
    const Vec3<D> x{a.xx, a.xy, a.zx}, y{a.xy, a.yy, a.yz}, z{a.zx, a.yz, a.zz};
    const auto of_x = product<D>(b, x), of_y = product<D>(b, y), of_z = product<D>(b, z);
    return {dot(x, of_x), dot(y, of_y), dot(z, of_z), dot(x, of_y), dot(y, of_z), dot(z, of_x)};
}

/// W_s = mu ((tr E)^2 / 2 + E : E), and g = J - 1. Strains are given as G = 2 E.
template <class D> class HookeLaw {
  public:
    HWY_INLINE HookeLaw(D d, hn::Vec<D> modulus, const Symmetric<D> &twice_strain)
        : modulus_(modulus), half_(hn::Mul(hn::Set(d, 0.5), modulus)), twice_strain_(twice_strain) {}

    HWY_INLINE hn::Vec<D> energy(D d) const {
        const auto &g = twice_strain_;
        const auto trace = hn::Add(g.xx, hn::Add(g.yy, g.zz));
        const auto sum = hn::MulAdd(hn::Mul(hn::Set(d, 0.5), trace), trace, contraction(g, g));
        return hn::Mul(hn::Mul(hn::Set(d, 0.25), modulus_), sum);
    }
    HWY_INLINE Symmetric<D> stress(D /*d*/) const { return of(twice_strain_); }
    /// Along a rate of G.
    HWY_INLINE Symmetric<D> stress_rate(D /*d*/, const Symmetric<D> &rate) const { return of(rate); }

    static HWY_INLINE SquaredVolume<D> volume(D d, hn::Vec<D> change) {
        return {hn::Mul(change, change), change, hn::Set(d, 1.0)};
    }
    static constexpr bool is_finite = true; ///< where a tetrahedron is inside out

  private:
    HWY_INLINE Symmetric<D> of(const Symmetric<D> &g) const {
        return livermark::msm::HWY_NAMESPACE::stress<D>(half_, modulus_, g);
    }

    hn::Vec<D> modulus_, half_;
    Symmetric<D> twice_strain_;
};

/// W_s = mu (tr E - L / 2 + L^2 / 8) with L = ln det C, and g = ln J: see spring_energies/neo_hookean.cpp. Where the
/// determinant is not positive it is taken for 1e-6, so that nothing is infinite but what the caller makes so.
template <class D> class NeoHookeanLaw {
  public:
    HWY_INLINE NeoHookeanLaw(D d, hn::Vec<D> modulus, const Symmetric<D> &twice_strain)
        : modulus_(modulus), twice_strain_(twice_strain), of_(cauchy_green(d, twice_strain, 0.0)),
          log_(hn::Log1p(d, of_.det_change)) {}

    HWY_INLINE hn::Vec<D> energy(D d) const {
        const auto half = hn::Set(d, 0.5), half_log = hn::Mul(half, log_);
        return hn::Mul(modulus_, hn::MulAdd(hn::Mul(half, half_log), half_log, hn::Mul(half, hn::Sub(of_.i1, log_))));
    }
    /// mu (I - C^-1 + L / 2 C^-1), from the invariants of G: see CauchyGreen.
    HWY_INLINE Symmetric<D> stress(D d) const {
        const auto one = hn::Set(d, 1.0), half_log = hn::Mul(hn::Set(d, 0.5), log_);
        const auto scale = hn::Div(modulus_, hn::Add(one, of_.det_change));
        const auto part = hn::Mul(scale, hn::Sub(one, half_log));
        const auto mean = hn::Mul(scale, hn::MulAdd(half_log, hn::Add(one, of_.i1), of_.two_and_three));
        return plus_identity(scaled<D>(part, minus<D>(twice_strain_, of_.adjugate)), mean);
    }
    /// mu ((1 - L / 2) C^-1 R C^-1 + (C^-1 : R) / 2 C^-1) along a rate R of G.
    HWY_INLINE Symmetric<D> stress_rate(D d, const Symmetric<D> &rate) const {
        const auto one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
        const auto inverse = scaled<D>(hn::Div(one, hn::Add(one, of_.det_change)),
                                       plus_identity(minus<D>(of_.adjugate, twice_strain_), hn::Add(one, of_.i1)));
        const auto of_turns = hn::Mul(modulus_, hn::NegMulAdd(half, log_, one));
        const auto of_volume = hn::Mul(modulus_, hn::Mul(half, contraction(inverse, rate)));
        return plus_scaled<D>(scaled<D>(of_turns, sandwich(inverse, rate)), of_volume, inverse);
    }

    static HWY_INLINE SquaredVolume<D> volume(D d, hn::Vec<D> change) {
        const auto one = hn::Set(d, 1.0), bounded = hn::Max(change, hn::Set(d, -1.0 + 1e-6));
        const auto log = hn::Log1p(d, bounded), inverse = hn::Div(one, hn::Add(one, bounded));
        return {hn::Mul(log, log), hn::Mul(log, inverse), hn::Mul(hn::Sub(one, log), hn::Mul(inverse, inverse))};
    }
    static constexpr bool is_finite = false;

  private:
    static HWY_INLINE Symmetric<D> plus_identity(Symmetric<D> a, hn::Vec<D> factor) {
        a.xx = hn::Add(a.xx, factor);
        a.yy = hn::Add(a.yy, factor);
        a.zz = hn::Add(a.zz, factor);
        return a;
    }

    hn::Vec<D> modulus_;
    Symmetric<D> twice_strain_;
    CauchyGreen<D> of_;
    hn::Vec<D> log_;
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_NEO_HOOKEAN_LAW_INL_HPP
