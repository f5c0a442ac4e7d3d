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

#include "msm/kernels/simd/means-inl.hpp"
#include "msm/kernels/simd/neo_hookean_law-inl.hpp"
#include "msm/kernels/simd/stars-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

// These are functions of their own, so that the loops of bodies without such springs stay as they are.

/// The stress in 16 control volumes, and a quarter of the pressure.
/// @tparam Means  MeansOfC or MeansOfF
template <bool is_damped, template <bool, class> class Means, class T>
HWY_NOINLINE void neo_hookean_stresses(StepWorkspace<T> &at, int now, int volume_slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    HWY_ALIGN std::array<T, slice_size> pressure;
    Means<is_damped, T> means(at, now, volume_slice);
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const std::size_t volume = static_cast<std::size_t>(volume_slice) * slice_size + lane;
        const auto modulus = hn::Load(d, body.coupled_modulus.data() + volume);
        const auto mean = means.mean(lane);
        auto total = neo_hookean_stress(D(), modulus, mean.tensor, at.least_stretch, largest);
        auto push = logarithmic_push(D(), mean.more, at.least_stretch);
        if constexpr (is_damped) {
            const auto rate = means.rate(lane);
            total = plus<D>(total, stress<D>(hn::Mul(hn::Set(d, T(0.5)), modulus), modulus, rate.tensor));
            push = hn::Add(push, rate.more);
        }
        means.store(without_faded(D(), at, total, volume), volume, at);
        if (!body.volume_stiffness.empty())
            hn::Store(hn::Mul(hn::Load(d, body.volume_stiffness.data() + volume), push), d, pressure.data() + lane);
    }
    if (!body.volume_stiffness.empty())
        set_pressures(at, now, volume_slice, pressure.data());
    largest.keep(D(), at, static_cast<int>(body.fan_start.size()) - 1 + volume_slice);
}

/// The stresses at the corners of a fan, where fans have to fetch them.
template <class Means, class D, bool act = Means::act_in_fans> struct FanStresses {
    template <class T> HWY_INLINE FanStresses(const StepWorkspace<T> & /*at*/, const std::int32_t * /*corner*/) {}

    template <class T>
    HWY_INLINE Columns<D> first_stress(D d, const StepWorkspace<T> & /*at*/, const std::int32_t * /*corner*/,
                                       const Columns<D> & /*f*/, std::size_t /*t*/, hn::Vec<D> /*modulus*/) {
        const auto zero = hn::Zero(d);
        return {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
    }
};
template <class Means, class D> struct FanStresses<Means, D, true> {
    typename Means::Stress axis, from;

    /// @param corner  of the start of the axis
    template <class T>
    HWY_INLINE FanStresses(const StepWorkspace<T> &at, const std::int32_t *corner)
        : axis(plus<D>(Means::fetch_at(at, corner), Means::fetch_at(at, corner + slice_size))),
          from(Means::fetch_at(at, corner + 2 * slice_size)) {}

    /// Of the tetrahedron between the last node of the rim and the one at `corner`; see MeansOfC.
    template <class T>
    HWY_INLINE Columns<D> first_stress(D d, const StepWorkspace<T> &at, const std::int32_t *corner, const Columns<D> &f,
                                       std::size_t t, hn::Vec<D> modulus) {
        const auto to = Means::fetch_at(at, corner);
        const auto sum = plus<D>(axis, plus<D>(from, to));
        from = to;
        const auto &faded = at.relaxation.tetrahedra.faded;
        return Means::first_stress(f, hn::Load(d, at.body.rest_volume.data() + t), sum, modulus,
                                   faded.empty() ? nullptr : faded.data() + first_of_six(t));
    }
};

/// The forces of stresses around nodes, of springs inside tetrahedra, and of pressures on the nodes of the fans of a
/// slice; see fan_forces(). What depends on the volume of a tetrahedron alone is there already, see put_push_inside();
/// so are the forces of means of F and of mu F inside, see MeansOfF::store().
/// @tparam Means  MeansOfC or MeansOfF, of which the stresses are
template <bool is_damped, template <bool, class> class Means, class T>
HWY_NOINLINE void neo_hookean_spring_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    using OfMeans = Means<is_damped, T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto *rim_slot = slot + 2 * slice_size;
        const auto axis = fetch_axis(D(), rows, corner);
        FanStresses<OfMeans, D> stresses(at, corner);
        FanRates<is_damped, D> rates;
        rates.begin(d, at, now, corner);
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        FanPulls<D> sums{D()};
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto zero = hn::Zero(d);
            OfCorners<D> pull{{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
            if constexpr (OfMeans::act_in_fans || is_damped) {
                const auto rest = rest_gradients(D(), body, t, lane);
                const auto f = gradient<D>({axis.direction, from.arm, to.arm}, rest);
                const auto modulus = hn::Load(d, body.inner_modulus.data() + t);
                auto stressed = stresses.first_stress(D(), at, corner, f, t, modulus);
                if constexpr (is_damped) {
                    const auto before = rates;
                    rates.arm = difference(fetch(d, at.velocity_rows[now].data(), corner), rates.start);
                    const auto rate = gradient<D>({rates.axis, before.arm, rates.arm}, rest);
                    const auto factor = hn::Mul(hn::Set(d, static_cast<T>(at.beta)), modulus);
                    const auto damping =
                        stress<D>(hn::Mul(hn::Set(d, T(0.5)), factor), factor, twice_strain_rate<D>(f, rate));
                    stressed = plus<D>(stressed, product<D>(f, damping));
                }
                pull = pulls<D>(stressed, rest);
            }
            const auto pressure = hn::Add(axis.pressure, hn::Add(from.pressure, to.pressure));
            const auto push = hn::NegMulAdd(hn::Mul(sixth, hn::Load(d, body.volume_share.data() + t)), pressure,
                                            hn::Load(d, at.push.data() + t));
            sums.add(D(), pull, push, from, to, at.corner_force, rim_slot);
            from = to;
        }
        sums.finish(D(), at.corner_force, slot, rim_slot);
    }
}

// Forces of neo-Hookean springs that are coupled around edges, for slices of stars.

/// The forces of the means around 16 edges on the nodes of their stars, and of mu F of springs inside tetrahedra on the
/// ends of these edges (slicing.hpp). What else tetrahedra do is left to their fans. The forces of a star have
/// no resultant, so the start of the axis gets what is left.
/// @tparam Stars  StarsOfF or StarsOfC
template <bool is_damped, template <bool, class> class Stars, class T>
HWY_NOINLINE void edge_spring_forces(StepWorkspace<T> &at, int now, int thread, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    T *kept = at.star_scratch[static_cast<std::size_t>(thread)].data();
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const StarPlaces places(body, slice, lane);
        const std::size_t star = static_cast<std::size_t>(slice) * slice_size + lane;
        const StarFetch<is_damped, T> fetch(at, now, places);
        const Stars<is_damped, T> means(at, fetch, places, hn::Load(d, body.star_inverse_volume.data() + star), kept);
        const auto modulus = hn::Load(d, body.star_modulus.data() + star);
        auto total = neo_hookean_stress(D(), modulus, means.mean(), at.least_stretch, largest);
        if constexpr (is_damped)
            total = plus<D>(total, stress<D>(hn::Mul(hn::Set(d, T(0.5)), modulus), modulus, means.rate()));
        total = without_faded(D(), at, total, star);
        const auto *slot = body.star_slot.data() + places.corner;
        auto sum = no_vector(D());
        const auto on_end = means.forces(total, [&](std::size_t k, const Vec3<D> &force) HWY_ATTR {
            add_force(D(), force, at.corner_force, slot + (2 + k) * slice_size);
            sum = plus(sum, force);
        });
        const auto pull = scaled<D>(hn::Load(d, body.star_stiffness.data() + star), fetch.axis().position);
        const auto end = minus(on_end, pull);
        add_force(D(), end, at.corner_force, slot + slice_size);
        add_force(D(), minus(no_vector(D()), plus(sum, end)), at.corner_force, slot);
    }
    largest.keep(D(), at,
                 static_cast<int>(body.fan_start.size()) - 1 + static_cast<int>(body.volume_row.size()) / slice_size +
                     slice);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_NEO_HOOKEAN_SPRINGS_INL_HPP
