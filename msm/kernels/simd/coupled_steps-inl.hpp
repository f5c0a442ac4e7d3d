// Forces of springs that are coupled around nodes or edges, with means of C or F. Written once for each vector unit:
// see take_steps.cpp.
#if defined(LIVERMARK_COUPLED_STEPS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_COUPLED_STEPS_INL_HPP
#undef LIVERMARK_COUPLED_STEPS_INL_HPP
#else
#define LIVERMARK_COUPLED_STEPS_INL_HPP
#endif

#include <algorithm>
#include <array>
#include <cmath>

#include "msm/kernels/energy_kernels.hpp"
#include "msm/kernels/simd/coupled_equilibria-inl.hpp"
#include "msm/kernels/simd/coupled_relaxation-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

// These are functions of their own, so that the loops of bodies without such springs stay as they are.

/// g g' of relative changes e of volumes.
template <template <class> class Energy, class D>
HWY_INLINE hn::Vec<D> volume_push(D d, hn::Vec<D> change, double least_stretch) {
    using T = hn::TFromD<D>;
    const auto least = hn::Set(d, static_cast<T>(-1.0 + std::max(1e-6, std::sqrt(least_stretch))));
    return Energy<D>::volume_push(d, hn::Max(change, least));
}

/// The stress in 16 control volumes, and a quarter of the pressure.
/// @tparam Means  MeansOfC or MeansOfF
template <bool is_damped, template <class> class Energy, template <bool, class> class Means, class T>
HWY_NOINLINE void stresses_around_nodes(StepWorkspace<T> &at, int now, int volume_slice) {
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
        const Energy<D> energy(D(), modulus, mean.tensor, at.least_stretch);
        largest.see(D(), energy.strain());
        auto total = energy.stress(D());
        auto push = volume_push<Energy>(D(), mean.more, at.least_stretch);
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

    /// Stress of the tetrahedron between the last node of the rim and the one at `corner`; see MeansOfC.
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
HWY_NOINLINE void coupled_fan_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    using OfMeans = Means<is_damped, T>;
    constexpr D d;
    const auto &body = at.body;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto *rim_slot = slot + 2 * slice_size;
        FanWalk<is_damped, T> fan(at, now, corner);
        FanStresses<OfMeans, D> stresses(at, corner);
        FanPulls<D> sums{D()};
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            fan.next();
            const auto zero = hn::Zero(d);
            OfCorners<D> pull{{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
            if constexpr (OfMeans::act_in_fans || is_damped) {
                const auto rest = rest_gradients(D(), body, t, lane);
                const auto f = gradient<D>({fan.axis.direction, fan.from.arm, fan.to.arm}, rest);
                const auto modulus = hn::Load(d, body.inner_modulus.data() + t);
                auto stressed = stresses.first_stress(D(), at, fan.corner, f, t, modulus);
                if constexpr (is_damped) {
                    const auto before = fan.rates;
                    fan.rates.arm = difference(fetch(d, at.velocity_rows[now].data(), fan.corner), fan.rates.start);
                    const auto rate = gradient<D>({fan.rates.axis, before.arm, fan.rates.arm}, rest);
                    const auto factor = hn::Mul(hn::Set(d, static_cast<T>(at.beta)), modulus);
                    const auto damping =
                        stress<D>(hn::Mul(hn::Set(d, T(0.5)), factor), factor, twice_strain_rate<D>(f, rate));
                    stressed = plus<D>(stressed, product<D>(f, damping));
                }
                pull = pulls<D>(stressed, rest);
            }
            const auto pressure = fan.pressure();
            const auto push = hn::NegMulAdd(hn::Mul(sixth, hn::Load(d, body.volume_share.data() + t)), pressure,
                                            hn::Load(d, at.push.data() + t));
            sums.add(D(), pull, push, fan.from, fan.to, at.corner_force, rim_slot);
        }
        sums.finish(D(), at.corner_force, slot, rim_slot);
    }
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

/// Means over the corners of tetrahedra around control volumes of a slice, those from `lane` on.
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
/// means are taken of g g' of these. See StepFunctions::stresses.
template <bool is_damped, template <class> class Energy, class T>
HWY_NOINLINE void mean_pressures(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    if (body.volume_stiffness.empty())
        return;
    const auto slices = at.volume_slices[thread];
    for (int slice = slices.first; slice < slices.last; ++slice) {
        put_changes(at, at.gain, slice, at.change);
        if constexpr (is_damped)
            put_changes(at, at.gain_rate, slice, at.change_rate);
    }
    barrier.wait();
    for (int slice = slices.first; slice < slices.last; ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::size_t first = static_cast<std::size_t>(slice) * slice_size + lane;
            auto push = volume_push<Energy>(D(), mean_around(D(), body, at.change, slice, lane), at.least_stretch);
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

// Forces of springs that are coupled around edges, for slices of stars.

/// The forces of the means around 16 edges on the nodes of their stars, and of mu F of springs inside tetrahedra on the
/// ends of these edges (slicing.hpp). What else tetrahedra do is left to their fans. The forces of a star have
/// no resultant, so the start of the axis gets what is left.
/// @tparam Stars  StarsOfF or StarsOfC
template <bool is_damped, template <class> class Energy, template <bool, class> class Stars, class T>
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
        const Energy<D> energy(D(), modulus, means.mean(), at.least_stretch);
        largest.see(D(), energy.strain());
        auto total = energy.stress(D());
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

/// See StepFunctions::stresses.
template <bool is_damped, template <class> class Energy, template <bool, class> class Means, class T>
void stresses_of_thread(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    const auto [first, last] = at.volume_slices[thread];
    for (int slice = first; slice < last; ++slice)
        stresses_around_nodes<is_damped, Energy, Means>(at, now, slice);
    barrier.wait();
}

template <bool is_damped, template <class> class Energy, class T>
StepFunctions<T> coupled_steps_of(const SlicedBody<T> &body) {
    const bool is_of_f = body.measure == StrainMeasure::deformation_gradient;
    StepFunctions<T> steps{.relax = relax_coupled<Energy, T>};
    if (body.has_volumes_in_fans()) {
        steps.put_means = volume_gains<is_damped, Energy, T>;
        steps.fan_forces = coupled_fan_forces<is_damped, MeansOfF, T>;
    } else {
        steps.put_means = corner_strains<is_damped, Energy, T>;
        steps.fan_forces = coupled_fan_forces<is_damped, MeansOfC, T>;
    }
    if (body.is_around_edges()) {
        steps.stresses = mean_pressures<is_damped, Energy, T>;
        steps.star_forces = is_of_f ? edge_spring_forces<is_damped, Energy, StarsOfF, T>
                                    : edge_spring_forces<is_damped, Energy, StarsOfC, T>;
    } else {
        steps.stresses = is_of_f ? stresses_of_thread<is_damped, Energy, MeansOfF, T>
                                 : stresses_of_thread<is_damped, Energy, MeansOfC, T>;
    }
    return steps;
}

template <template <class> class Energy, class T>
StepFunctions<T> coupled_steps(const SlicedBody<T> &body, bool is_damped) {
    return is_damped ? coupled_steps_of<true, Energy>(body) : coupled_steps_of<false, Energy>(body);
}

template <template <class> class Energy> EquilibriumFunctions coupled_equilibrium(StrainMeasure measure) {
    return measure == StrainMeasure::deformation_gradient ? equilibrium_functions<Energy, MeansOfGradients>()
                                                          : equilibrium_functions<Energy, MeansOfStrains>();
}

/// All that kernels do with an energy of means of C or F. With G = C - I in vectors D, Energy<D>(d, mu, G,
/// least_stretch) has
///   strain()             CauchyGreen of G
///   stress(d)            S, see SpringEnergy, here and below
///   isochoric_stress(d)
/// and, of doubles with no least stretch, for equilibria
///   energy(d)            W_s
///   stress_rate(d, R)    how fast S grows where G grows by R
///   volume(d, change)    g^2 and the derivatives of g^2 / 2, see SquaredVolume
///   is_finite
/// and for steps
///   volume_push(d, e)           g g' of a relative change of volume
///   push_inside(d, j, square)   p(J) of springs inside tetrahedra, P = mu (F - p(J) cof F), with J and a square of it
///   that is
///                               not too small: kernels know energies alone of which P is that, W_s = mu (tr E + h(J))
template <template <class> class Energy> EnergyFunctions functions_of_energy() {
    EnergyFunctions functions{.steps = coupled_steps<Energy, float>, .equilibrium = coupled_equilibrium<Energy>};
#if HWY_HAVE_FLOAT64
    functions.double_steps = coupled_steps<Energy, double>;
#endif
    return functions;
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_COUPLED_STEPS_INL_HPP
