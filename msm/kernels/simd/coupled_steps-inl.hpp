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

/// Stresses that act in fans: none.
template <class T> class NoStresses {
    using D = Lanes<T>;

  public:
    static constexpr bool act = false;
    HWY_INLINE NoStresses(const StepWorkspace<T> & /*at*/, int /*slice*/, std::size_t /*lane*/,
                          const std::int32_t * /*corner*/) {}
    HWY_INLINE Columns<D> next(const std::int32_t * /*corner*/, const Columns<D> & /*f*/, std::size_t /*t*/,
                               hn::Vec<D> /*modulus*/) {
        const auto zero = hn::Zero(D());
        return {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
    }
};

/// Part of the stress inside tetrahedra that has relaxed; null if none does.
template <class T> HWY_INLINE const T *faded_inside(const StepWorkspace<T> &at, std::size_t t) {
    const auto &faded = at.relaxation.tetrahedra.faded;
    return faded.empty() ? nullptr : faded.data() + first_of_six(t);
}

/// Stresses at the corners of a fan, with means of C around nodes.
template <class T> class NodalStresses {
    using D = Lanes<T>;
    using Means = MeansOfC<false, T>;

  public:
    static constexpr bool act = true;
    /// @param corner  of the start of the axis
    HWY_INLINE NodalStresses(const StepWorkspace<T> &at, int /*slice*/, std::size_t /*lane*/,
                             const std::int32_t *corner)
        : at_(at), axis_(plus<D>(Means::fetch_at(at, corner), Means::fetch_at(at, corner + slice_size))),
          from_(Means::fetch_at(at, corner + 2 * slice_size)) {}

    /// Stress of the tetrahedron between the last node of the rim and the one at `corner`; see MeansOfC.
    HWY_INLINE Columns<D> next(const std::int32_t *corner, const Columns<D> &f, std::size_t t, hn::Vec<D> modulus) {
        const auto to = Means::fetch_at(at_, corner);
        const auto sum = plus<D>(axis_, plus<D>(from_, to));
        from_ = to;
        return Means::first_stress(f, hn::Load(D(), at_.body.rest_volume.data() + t), sum, modulus,
                                   faded_inside(at_, t));
    }

  private:
    const StepWorkspace<T> &at_;
    typename Means::Stress axis_, from_;
};

/// Stresses at the edges of a fan.
template <template <class> class Means, class T> class EdgeStresses {
    using D = Lanes<T>;

  public:
    static constexpr bool act = true;
    HWY_INLINE EdgeStresses(const StepWorkspace<T> &at, int slice, std::size_t lane, const std::int32_t * /*corner*/)
        : at_(at), sums_(at, slice, lane) {}
    HWY_INLINE Columns<D> next(const std::int32_t * /*corner*/, const Columns<D> &f, std::size_t t,
                               hn::Vec<D> modulus) {
        return Means<D>::first_stress(f, hn::Load(D(), at_.body.rest_volume.data() + t), sums_.next(), modulus,
                                      faded_inside(at_, t));
    }

  private:
    const StepWorkspace<T> &at_;
    EdgeSums<Means, T> sums_;
};
template <class T> using EdgeStressesOfC = EdgeStresses<EdgeMeansOfC, T>;
template <class T> using EdgeStressesOfF = EdgeStresses<EdgeMeansOfF, T>;

/// The forces of stresses around nodes or edges, of springs inside tetrahedra, and of pressures on the nodes of the
/// fans of a slice; see fan_forces(). What depends on the volume of a tetrahedron alone is there already, see
/// put_push_inside(); so are the forces of means of F around nodes and of mu F inside beside them, see
/// MeansOfF::store().
/// @tparam Stresses  NoStresses, NodalStresses or EdgeStresses
template <bool is_damped, template <class> class Stresses, class T>
HWY_NOINLINE void coupled_fan_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto *rim_slot = slot + 2 * slice_size;
        FanWalk<is_damped, T> fan(at, now, corner);
        Stresses<T> stresses(at, slice, lane, corner);
        FanPulls<D> sums{D()};
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            fan.next();
            const auto zero = hn::Zero(d);
            OfCorners<D> pull{{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
            if constexpr (Stresses<T>::act || is_damped) {
                const auto rest = rest_gradients(D(), body, t, lane);
                const auto f = gradient<D>({fan.axis.direction, fan.from.arm, fan.to.arm}, rest);
                const auto modulus = hn::Load(d, body.inner_modulus.data() + t);
                auto stressed = stresses.next(fan.corner, f, t, modulus);
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
/// means are taken of g g' of these.
template <bool is_damped, template <class> class Energy, class T>
HWY_NOINLINE void mean_pressures(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
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

// Stresses around edges.

/// The stresses of 16 edges, where the tetrahedra around these find them.
/// @tparam Means  EdgeMeansOfC or EdgeMeansOfF
template <bool is_damped, template <class> class Energy, template <class> class Means, class T>
HWY_NOINLINE void stresses_around_edges(StepWorkspace<T> &at, int slice) {
    using D = Lanes<T>;
    using OfTensor = typename Means<D>::OfTensor;
    constexpr D d;
    const auto &body = at.body;
    LargestDeficit<D> largest{D()};
    const std::size_t first = static_cast<std::size_t>(slice) * slice_size;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const auto mean = mean_around_edges<Means>(D(), body, at.tetrahedron_strain, slice, lane);
        const auto modulus = hn::Load(d, body.edge_modulus.data() + first + lane);
        const Energy<D> energy(D(), modulus, OfTensor::twice_strain(mean), at.least_stretch);
        largest.see(D(), energy.strain());
        auto total = energy.stress(D());
        if constexpr (is_damped) {
            const auto rate = OfTensor::twice_strain_rate_of(
                D(), mean, mean_around_edges<Means>(D(), body, at.tetrahedron_rate, slice, lane));
            total = plus<D>(total, stress<D>(hn::Mul(hn::Set(d, T(0.5)), modulus), modulus, rate));
        }
        total = without_faded(D(), at, total, first + lane);
        Means<D>::put(D(), OfTensor::stress(D(), mean, total), at.edge_stress.data() + Means<D>::row_size * first,
                      lane);
    }
    largest.keep(D(), at,
                 static_cast<int>(body.fan_start.size()) - 1 + static_cast<int>(body.volume_row.size()) / slice_size +
                     slice);
}

/// See StepFunctions::stresses.
template <bool is_damped, template <class> class Energy, template <class> class Means, class T>
void stresses_with_mean_pressures(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    for (int slice = at.edge_slices[thread].first; slice < at.edge_slices[thread].last; ++slice)
        stresses_around_edges<is_damped, Energy, Means>(at, slice);
    if (at.body.volume_stiffness.empty())
        barrier.wait();
    else
        mean_pressures<is_damped, Energy>(at, now, thread, barrier);
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
    const auto with = [](auto put_means, auto stresses, auto fan_forces) {
        return StepFunctions<T>{
            .put_means = put_means, .stresses = stresses, .fan_forces = fan_forces, .relax = relax_coupled<Energy, T>};
    };
    const bool is_of_f = body.measure == StrainMeasure::deformation_gradient;
    if (body.is_around_edges() && is_of_f)
        return with(fan_strains<is_damped, Energy, FanStrainsOfF, T>,
                    stresses_with_mean_pressures<is_damped, Energy, EdgeMeansOfF, T>,
                    coupled_fan_forces<is_damped, EdgeStressesOfF, T>);
    if (body.is_around_edges())
        return with(fan_strains<is_damped, Energy, FanStrainsOfC, T>,
                    stresses_with_mean_pressures<is_damped, Energy, EdgeMeansOfC, T>,
                    coupled_fan_forces<is_damped, EdgeStressesOfC, T>);
    if (is_of_f)
        return with(volume_gains<is_damped, Energy, T>, stresses_of_thread<is_damped, Energy, MeansOfF, T>,
                    coupled_fan_forces<is_damped, NoStresses, T>);
    return with(fan_strains<is_damped, Energy, CornerStrains, T>, stresses_of_thread<is_damped, Energy, MeansOfC, T>,
                coupled_fan_forces<is_damped, NodalStresses, T>);
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
