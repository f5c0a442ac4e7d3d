// Forces of neo-Hookean springs that are coupled around nodes, for slices of fans of tetrahedra. Written once for each
// vector unit: see take_steps.cpp.
#if defined(LIVERMARK_NEO_HOOKEAN_SPRINGS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_NEO_HOOKEAN_SPRINGS_INL_HPP
#undef LIVERMARK_NEO_HOOKEAN_SPRINGS_INL_HPP
#else
#define LIVERMARK_NEO_HOOKEAN_SPRINGS_INL_HPP
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <hwy/contrib/math/math-inl.h>

#include "msm/kernels/simd/biquadratic_springs-inl.hpp"
#include "msm/kernels/simd/nodal_springs-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

// These are functions of their own, so that the loops of bodies without such springs stay as they are.

/// Twice a strain, times a volume, and a volume gained. Sums of them over the tetrahedra at a corner of a fan.
template <class D> HWY_INLINE SymmetricAndMore<D> plus(const SymmetricAndMore<D> &a, const SymmetricAndMore<D> &b) {
    return {plus<D>(a.tensor, b.tensor), hn::Add(a.more, b.more)};
}
template <class D, class T>
HWY_INLINE void store(D d, const SymmetricAndMore<D> &value, std::array<Aligned<T>, 2> &at, std::size_t corner) {
    const auto &[xx, yy, zz, xy, yz, zx] = value.tensor;
    hn::StoreInterleaved4(xx, yy, zz, xy, d, at[0].data() + 4 * corner);
    hn::StoreInterleaved4(yz, zx, value.more, hn::Zero(d), d, at[1].data() + 4 * corner);
}

/// What the tetrahedra of a fan have, put down at its corners as sums over those that meet there.
template <class D> struct CornerSums {
    SymmetricAndMore<D> before, sum;

    HWY_INLINE explicit CornerSums(D d)
        : before{{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)}, hn::Zero(d)},
          sum(before) {}

    template <class T>
    HWY_INLINE void add(D d, const SymmetricAndMore<D> &value, std::array<Aligned<T>, 2> &at, std::size_t rim_corner) {
        store(d, plus<D>(before, value), at, rim_corner);
        sum = plus<D>(sum, value);
        before = value;
    }
    template <class T>
    HWY_INLINE void finish(D d, std::array<Aligned<T>, 2> &at, std::size_t first_corner,
                           std::size_t last_rim_corner) const {
        store(d, before, at, last_rim_corner);
        store(d, sum, at, first_corner);
        store(d, sum, at, first_corner + slice_size);
    }
};

/// Of the fans of a slice, for the means around nodes.
template <bool is_damped, class T> HWY_NOINLINE void neo_hookean_strains(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto axis = fetch_axis(D(), rows, corner);
        FanRates<is_damped, D> rates;
        rates.begin(d, at, now, corner);
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        std::size_t rim = lines.corner + 2 * slice_size;
        CornerSums<D> strains{D()};
        [[maybe_unused]] CornerSums<D> growth{D()};
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto rest = rest_gradients(D(), body, t, lane);
            const auto f = gradient<D>({axis.direction, from.arm, to.arm}, rest);
            const auto rest_volume = hn::Load(d, body.rest_volume.data() + t);
            const auto volume = dot(from.lever, to.arm);
            strains.add(D(), {scaled<D>(rest_volume, twice_strain(D(), f)), hn::MulSub(volume, sixth, rest_volume)},
                        at.corner_strain, rim);
            if constexpr (is_damped) {
                const auto before = rates;
                const auto damped = volume_between<true>(D(), at, now, from, to, corner, rates);
                const auto rate = gradient<D>({rates.axis, before.arm, rates.arm}, rest);
                const auto factor = hn::Mul(hn::Set(d, static_cast<T>(at.beta)), rest_volume);
                growth.add(D(),
                           {scaled<D>(factor, twice_strain_rate<D>(f, rate)), hn::Mul(hn::Sub(damped, volume), sixth)},
                           at.corner_rate, rim);
            }
            from = to;
        }
        strains.finish(D(), at.corner_strain, lines.corner, rim);
        if constexpr (is_damped)
            growth.finish(D(), at.corner_rate, lines.corner, rim);
    }
}

/// S = mu (I - C^-1 + 1/2 ln det C C^-1) with C = I + G, where with the invariants I1, I2 and I3 of G
///   det C = 1 + I1 + I2 + I3,   C^-1 det C = (1 + I1) I - G + adj G,   (I - C^-1) det C = G - adj G + (I2 + I3) I,
/// so that small strains lose no digits.
/// @param twice_strain  G
/// @param least_stretch  see FastStepOptions; det C is taken as if no less than the trace of its adjugate allows
/// @param largest        told how much det C lacks of what makes the trace of C^-1 four
template <class D>
HWY_INLINE Symmetric<D> neo_hookean_stress(D d, hn::Vec<D> shear_modulus, const Symmetric<D> &twice_strain,
                                           double least_stretch, LargestLack<D> &largest) {
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
    largest.lack = hn::Max(largest.lack, hn::Sub(hn::MulSub(hn::Set(d, T(0.25)), adjugate_trace, one), exact));
    const auto change = hn::Max(hn::Max(exact, bent), least);
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

/// Of 16 control volumes, what the corners of fans there have: eight numbers for each.
template <class T>
HWY_INLINE void sum_of_corners(const StepWorkspace<T> &at, const std::array<Aligned<T>, 2> &corners, int volume_slice,
                               T *first_four, T *other_four) {
    constexpr hn::CappedTag<T, 4> four;
    const auto &body = at.body;
    const std::size_t first = static_cast<std::size_t>(body.volume_start[volume_slice]) * slice_size;
    const std::size_t end = static_cast<std::size_t>(body.volume_start[volume_slice + 1]) * slice_size;
    // Four rows and both parts of them at once, because each sum has to wait for the one before.
    for (std::size_t row = 0; row < slice_size; row += 4)
        for (std::size_t part = 0; part < 4; part += hn::Lanes(four)) {
            const T *one = corners[0].data() + part, *other = corners[1].data() + part;
            const auto *member = body.member.data() + row;
            auto a = hn::Zero(four), b = a, c = a, e = a, p = a, q = a, r = a, s = a;
            for (std::size_t m = first; m < end; m += slice_size) {
                a = hn::Add(a, hn::LoadU(four, one + member[m]));
                p = hn::Add(p, hn::LoadU(four, other + member[m]));
                b = hn::Add(b, hn::LoadU(four, one + member[m + 1]));
                q = hn::Add(q, hn::LoadU(four, other + member[m + 1]));
                c = hn::Add(c, hn::LoadU(four, one + member[m + 2]));
                r = hn::Add(r, hn::LoadU(four, other + member[m + 2]));
                e = hn::Add(e, hn::LoadU(four, one + member[m + 3]));
                s = hn::Add(s, hn::LoadU(four, other + member[m + 3]));
            }
            T *sum = first_four + 4 * row + part, *other_sum = other_four + 4 * row + part;
            hn::StoreU(a, four, sum);
            hn::StoreU(b, four, sum + 4);
            hn::StoreU(c, four, sum + 8);
            hn::StoreU(e, four, sum + 12);
            hn::StoreU(p, four, other_sum);
            hn::StoreU(q, four, other_sum + 4);
            hn::StoreU(r, four, other_sum + 8);
            hn::StoreU(s, four, other_sum + 12);
        }
}

/// From two times four numbers of each of some nodes behind each other.
template <class D, class T> HWY_INLINE SymmetricAndMore<D> load_both(D d, const T *first_four, const T *other_four) {
    hn::Vec<D> xx, yy, zz, xy, yz, zx, more, nothing;
    hn::LoadInterleaved4(d, first_four, xx, yy, zz, xy);
    hn::LoadInterleaved4(d, other_four, yz, zx, more, nothing);
    return {{xx, yy, zz, xy, yz, zx}, more};
}

/// g g' of relative changes e of volumes, for g = ln (1 + e).
template <class D> HWY_INLINE hn::Vec<D> logarithmic_push(D d, hn::Vec<D> change, double least_stretch) {
    using T = hn::TFromD<D>;
    const auto e = hn::Max(change, hn::Set(d, static_cast<T>(-1.0 + std::max(1e-6, std::sqrt(least_stretch)))));
    return hn::Div(hn::Log1p(d, e), hn::Add(hn::Set(d, T(1)), e));
}

/// A quarter of the stress in 16 control volumes, and of the pressure.
template <bool is_damped, class T>
HWY_NOINLINE void neo_hookean_stresses(StepWorkspace<T> &at, int now, int volume_slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    HWY_ALIGN std::array<T, 4 * slice_size> first_four, other_four, first_rates, other_rates;
    HWY_ALIGN std::array<T, slice_size> pressure;
    sum_of_corners(at, at.corner_strain, volume_slice, first_four.data(), other_four.data());
    if constexpr (is_damped)
        sum_of_corners(at, at.corner_rate, volume_slice, first_rates.data(), other_rates.data());
    LargestLack<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const std::size_t volume = static_cast<std::size_t>(volume_slice) * slice_size + lane;
        const auto mean = load_both(D(), first_four.data() + 4 * lane, other_four.data() + 4 * lane);
        const auto modulus = hn::Load(d, body.coupled_modulus.data() + volume);
        const auto inverse_volume = hn::Load(d, body.inverse_volume.data() + volume);
        auto total =
            neo_hookean_stress(D(), modulus, scaled<D>(inverse_volume, mean.tensor), at.least_stretch, largest);
        auto push = logarithmic_push(D(), hn::Mul(inverse_volume, mean.more), at.least_stretch);
        if constexpr (is_damped) {
            const auto rate = load_both(D(), first_rates.data() + 4 * lane, other_rates.data() + 4 * lane);
            const auto factor = hn::Mul(modulus, inverse_volume);
            total = plus<D>(total, stress<D>(hn::Mul(hn::Set(d, T(0.5)), factor), factor, rate.tensor));
            push = hn::MulAdd(inverse_volume, rate.more, push);
        }
        store_stress(D(), total, volume, at);
        if (!body.volume_stiffness.empty())
            hn::Store(hn::Mul(hn::Load(d, body.volume_stiffness.data() + volume), push), d, pressure.data() + lane);
    }
    if (!body.volume_stiffness.empty())
        set_pressures(at, now, volume_slice, pressure.data());
    largest.keep(D(), at, static_cast<int>(body.fan_start.size()) - 1 + volume_slice);
}

/// The forces of stresses around nodes, of springs inside tetrahedra, and of pressures on the nodes of the fans of a
/// slice; see fan_forces(). All are P g of each corner with P = F S + q cof F: inside a tetrahedron S = mu (I - C^-1 +
/// ln J C^-1) makes of it mu F + mu (ln J - 1) / J cof F, and V0 cof F g is the gradient of the volume.
template <bool is_damped, class T>
HWY_NOINLINE void neo_hookean_spring_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const auto one = hn::Set(d, T(1)), six = hn::Set(d, T(6)),
               least = hn::Set(d, static_cast<T>(std::max(1e-12, at.least_stretch * at.least_stretch)));
    const auto zero = hn::Zero(d);
    LargestLack<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto *rim_slot = slot + 2 * slice_size;
        const auto axis = fetch_axis(D(), rows, corner);
        const auto axis_stress = plus<D>(fetch_stress(D(), at, corner), fetch_stress(D(), at, corner + slice_size));
        FanRates<is_damped, D> rates;
        rates.begin(d, at, now, corner);
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        auto from_stress = fetch_stress(D(), at, corner);
        FanPulls<D> sums{D()};
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto to_stress = fetch_stress(D(), at, corner);
            const auto rest = rest_gradients(D(), body, t, lane);
            const auto f = gradient<D>({axis.direction, from.arm, to.arm}, rest);
            const Columns<D> cofactor{cross(f.y, f.z), cross(f.z, f.x), cross(f.x, f.y)};
            const auto j = dot(f.x, cofactor.x);
            const auto square = hn::Max(hn::Mul(j, j), least);
            const auto log = hn::Mul(hn::Set(d, T(0.5)), hn::Log(d, square));

            const auto rest_volume = hn::Load(d, body.rest_volume.data() + t);
            const auto modulus = hn::Load(d, body.inner_modulus.data() + t);
            auto around = scaled<D>(rest_volume, plus<D>(axis_stress, plus<D>(from_stress, to_stress)));
            around.xx = hn::Add(around.xx, modulus);
            around.yy = hn::Add(around.yy, modulus);
            around.zz = hn::Add(around.zz, modulus);
            if constexpr (is_damped) {
                const auto before = rates;
                rates.arm = difference(fetch(d, at.velocity_rows[now].data(), corner), rates.start);
                const auto rate = gradient<D>({rates.axis, before.arm, rates.arm}, rest);
                const auto factor = hn::Mul(hn::Set(d, static_cast<T>(at.beta)), modulus);
                around = plus<D>(around,
                                 stress<D>(hn::Mul(hn::Set(d, T(0.5)), factor), factor, twice_strain_rate<D>(f, rate)));
            }
            const auto volume = hn::Mul(six, hn::Mul(rest_volume, j));
            const auto pressure = hn::Add(axis.pressure, hn::Add(from.pressure, to.pressure));
            const auto push =
                hn::Mul(hn::Mul(six, rest_volume), push_on(D(), body, pressure, volume, volume, t, largest));
            // (ln J - 1) / J, with the sign of J
            const auto inside = hn::Mul(hn::Mul(modulus, hn::Sub(log, one)), hn::Div(j, square));
            const auto on_cofactor = hn::Sub(inside, push);
            const auto stressed = product<D>(f, around);
            const Columns<D> first_stress{plus_scaled<D>(stressed.x, on_cofactor, cofactor.x),
                                          plus_scaled<D>(stressed.y, on_cofactor, cofactor.y),
                                          plus_scaled<D>(stressed.z, on_cofactor, cofactor.z)};
            sums.add(D(), pulls<D>(first_stress, rest), zero, from, to, at.corner_force, rim_slot);
            from = to;
            from_stress = to_stress;
        }
        sums.finish(D(), at.corner_force, slot, rim_slot);
    }
    largest.keep(D(), at, slice);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_NEO_HOOKEAN_SPRINGS_INL_HPP
