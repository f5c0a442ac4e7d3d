// Hooke's law of elongations, for springs around nodes.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/energies/hooke.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h

#include "core/support/vector_dispatch.hpp"
#include "msm/kernels/energy_kernels.hpp"
#include "msm/kernels/simd/coupled_equilibria-inl.hpp"
#include "msm/kernels/simd/coupled_relaxation-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Places of rows of eight numbers behind each other.
inline constexpr std::int32_t rows_of_eight[slice_size] = {0,  8,  16, 24, 32, 40,  48,  56,
                                                           64, 72, 80, 88, 96, 104, 112, 120};

template <class D, class T> HWY_INLINE SymmetricAndMore<D> load_eight(D d, const T *rows) {
    const auto a = fetch(d, rows, rows_of_eight), b = fetch(d, rows + 4, rows_of_eight);
    return {{a.x, a.y, a.z, a.w, b.x, b.y}, b.z};
}
template <class D, class T> HWY_INLINE void store_eight(D d, const SymmetricAndMore<D> &value, T *rows) {
    HWY_ALIGN T first[4 * hn::MaxLanes(D())], second[4 * hn::MaxLanes(D())];
    const auto &[xx, yy, zz, xy, yz, zx] = value.tensor;
    hn::StoreInterleaved4(xx, yy, zz, xy, d, first);
    hn::StoreInterleaved4(yz, zx, value.more, hn::Zero(d), d, second);
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
        std::copy_n(first + 4 * lane, 4, rows + 8 * lane);
        std::copy_n(second + 4 * lane, 4, rows + 8 * lane + 4);
    }
}

/// Something of each of the six edges of a tetrahedron: from the start of the axis to its end (a) and to the nodes of
/// the rim (b and c), and around these three.
template <class V> struct OfFanEdges { V a, b, c, ab, bc, ca; };

/// Lengths at rest.
/// @param t  place on the lines
template <class D, class T>
HWY_INLINE OfFanEdges<hn::Vec<D>> rest_lengths(D d, const SlicedBody<T> &body, std::size_t t, std::size_t lane) {
    const T *at = body.rest_length.data() + 6 * (t - lane) + lane;
    const auto load = [&](int k) HWY_ATTR { return hn::Load(d, at + k * slice_size); };
    return {load(0), load(1), load(2), load(3), load(4), load(5)};
}

template <class D> HWY_INLINE OfFanEdges<Vec3<D>> edge_spans(const Vec3<D> &a, const Vec3<D> &b, const Vec3<D> &c) {
    return {a, b, c, minus(b, a), minus(c, b), minus(a, c)};
}

/// Length at rest over length.
template <class D> HWY_INLINE hn::Vec<D> shortening(D d, const Vec3<D> &span, hn::Vec<D> rest_length) {
    const auto square = squared_length(d, span);
    return hn::Mul(rest_length, refined(d, square, guess_of_inverse_root(d, square)));
}
template <class D>
HWY_INLINE OfFanEdges<hn::Vec<D>> shortenings(D d, const OfFanEdges<Vec3<D>> &span,
                                              const OfFanEdges<hn::Vec<D>> &rest) {
    return {shortening(d, span.a, rest.a),   shortening(d, span.b, rest.b),   shortening(d, span.c, rest.c),
            shortening(d, span.ab, rest.ab), shortening(d, span.bc, rest.bc), shortening(d, span.ca, rest.ca)};
}

/// l0 (l - l0), half the stretch of an edge.
template <class D> HWY_INLINE hn::Vec<D> half_stretch(D d, const Vec3<D> &span, hn::Vec<D> rest_length) {
    const auto square = squared_length(d, span);
    const auto length = hn::Mul(square, refined(d, square, guess_of_inverse_root(d, square)));
    return hn::Mul(rest_length, hn::Sub(length, rest_length));
}
template <class D>
HWY_INLINE OfFanEdges<hn::Vec<D>> half_stretches(D d, const OfFanEdges<Vec3<D>> &span,
                                                 const OfFanEdges<hn::Vec<D>> &rest) {
    return {half_stretch(d, span.a, rest.a),   half_stretch(d, span.b, rest.b),   half_stretch(d, span.c, rest.c),
            half_stretch(d, span.ab, rest.ab), half_stretch(d, span.bc, rest.bc), half_stretch(d, span.ca, rest.ca)};
}

/// beta times how fast half the stretches grow.
template <class D>
HWY_INLINE OfFanEdges<hn::Vec<D>> plus_rates(const OfFanEdges<hn::Vec<D>> &stretch, hn::Vec<D> beta,
                                             const OfFanEdges<hn::Vec<D>> &shortening, const OfFanEdges<Vec3<D>> &span,
                                             const OfFanEdges<Vec3<D>> &rate) {
    const auto grown = [&](const hn::Vec<D> &s, const hn::Vec<D> &r, const Vec3<D> &x, const Vec3<D> &v)
                           HWY_ATTR { return hn::MulAdd(hn::Mul(beta, r), dot(x, v), s); };
    return {grown(stretch.a, shortening.a, span.a, rate.a),     grown(stretch.b, shortening.b, span.b, rate.b),
            grown(stretch.c, shortening.c, span.c, rate.c),     grown(stretch.ab, shortening.ab, span.ab, rate.ab),
            grown(stretch.bc, shortening.bc, span.bc, rate.bc), grown(stretch.ca, shortening.ca, span.ca, rate.ca)};
}

/// E = sum over corners m, n but the first of A_mn g_m g_n^T, where A_mm is half the stretch from the first corner and
/// 2 A_mn = A_mm + A_nn - half the stretch between m and n: what the law of cosines makes of
/// E = -1/4 sum over edges of q (g g^T + g g^T).
template <class D>
HWY_INLINE Symmetric<D> strain_of(D d, const OfFanEdges<hn::Vec<D>> &half, const OfCorners<D> &rest) {
    const auto between = [&](const hn::Vec<D> &m, const hn::Vec<D> &n, const hn::Vec<D> &edge)
                             HWY_ATTR { return hn::Mul(hn::Set(d, hn::TFromD<D>(0.5)), hn::Sub(hn::Add(m, n), edge)); };
    const auto ab = between(half.a, half.b, half.ab), bc = between(half.b, half.c, half.bc),
               ca = between(half.c, half.a, half.ca);
    const auto along_a = combined<D>(half.a, rest.a, ab, rest.b, ca, rest.c);
    const auto along_b = combined<D>(ab, rest.a, half.b, rest.b, bc, rest.c);
    const auto along_c = combined<D>(ca, rest.a, bc, rest.b, half.c, rest.c);
    const auto sum = [](const hn::Vec<D> &xa, const hn::Vec<D> &ya, const hn::Vec<D> &xb, const hn::Vec<D> &yb,
                        const hn::Vec<D> &xc, const hn::Vec<D> &yc)
                         HWY_ATTR { return hn::MulAdd(xa, ya, hn::MulAdd(xb, yb, hn::Mul(xc, yc))); };
    return {sum(rest.a.x, along_a.x, rest.b.x, along_b.x, rest.c.x, along_c.x),
            sum(rest.a.y, along_a.y, rest.b.y, along_b.y, rest.c.y, along_c.y),
            sum(rest.a.z, along_a.z, rest.b.z, along_b.z, rest.c.z, along_c.z),
            sum(rest.a.x, along_a.y, rest.b.x, along_b.y, rest.c.x, along_c.y),
            sum(rest.a.y, along_a.z, rest.b.y, along_b.z, rest.c.y, along_c.z),
            sum(rest.a.z, along_a.x, rest.b.z, along_b.x, rest.c.z, along_c.x)};
}

// These are functions of their own, so that the loops of bodies without such springs stay as they are.

/// Volume times the strain of each tetrahedron of the fans of a slice, and the volume that it has gained, with beta
/// times how fast they grow.
template <bool is_damped, class T> HWY_NOINLINE void nodal_strains(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        FanWalk<is_damped, T> fan(at, now, body.corner.data() + lines.corner);
        for (std::size_t t = lines.first; t < lines.end; t += slice_size) {
            fan.next();
            const auto rest_length = rest_lengths(D(), body, t, lane);
            const auto span = edge_spans<D>(fan.axis.direction, fan.from.arm, fan.to.arm);
            auto half = half_stretches(D(), span, rest_length);
            [[maybe_unused]] const auto before = fan.rates;
            const auto volume = hn::Mul(hn::Load(d, body.volume_share.data() + t), fan.volume(at, now));
            if constexpr (is_damped)
                half = plus_rates<D>(half, hn::Set(d, static_cast<T>(at.beta)), shortenings(D(), span, rest_length),
                                     span, edge_spans<D>(fan.rates.axis, before.arm, fan.rates.arm));
            const auto rest_volume = hn::Load(d, body.rest_volume.data() + t);
            store_eight(D(),
                        {scaled<D>(rest_volume, strain_of(D(), half, rest_gradients(D(), body, t, lane))),
                         hn::MulSub(volume, sixth, rest_volume)},
                        at.strain.data() + 8 * t);
        }
    }
}

/// Sums over the tetrahedra of 16 control volumes of what nodal_strains() puts down.
/// @param sums  (16, 8)
template <class T> HWY_INLINE void sum_of_strains(const StepWorkspace<T> &at, int volume_slice, T *sums) {
    constexpr hn::CappedTag<T, 8> eight;
    const auto &body = at.body;
    const std::size_t first = static_cast<std::size_t>(body.volume_start[volume_slice]) * slice_size;
    const std::size_t end = static_cast<std::size_t>(body.volume_start[volume_slice + 1]) * slice_size;
    // Four rows at once, because each sum has to wait for the one before.
    for (std::size_t row = 0; row < slice_size; row += 4)
        for (std::size_t part = 0; part < 8; part += hn::Lanes(eight)) {
            const T *strain = at.strain.data() + part;
            const auto *member = body.member.data() + row;
            auto a = hn::Zero(eight), b = a, c = a, e = a;
            for (std::size_t m = first; m < end; m += slice_size) {
                a = hn::Add(a, hn::Load(eight, strain + member[m]));
                b = hn::Add(b, hn::Load(eight, strain + member[m + 1]));
                c = hn::Add(c, hn::Load(eight, strain + member[m + 2]));
                e = hn::Add(e, hn::Load(eight, strain + member[m + 3]));
            }
            hn::Store(a, eight, sums + 8 * row + part);
            hn::Store(b, eight, sums + 8 * row + 8 + part);
            hn::Store(c, eight, sums + 8 * row + 16 + part);
            hn::Store(e, eight, sums + 8 * row + 24 + part);
        }
}

/// A quarter of the stress in 16 control volumes, from the strains of the tetrahedra there, and the pressures
/// there.
template <class T> HWY_NOINLINE void nodal_stresses(StepWorkspace<T> &at, int now, int volume_slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    HWY_ALIGN T sums[slice_size * 8];
    sum_of_strains(at, volume_slice, sums);
    HWY_ALIGN T gain[slice_size];
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const auto strain = load_eight(D(), sums + 8 * lane);
        const std::size_t volume = static_cast<std::size_t>(volume_slice) * slice_size + lane;
        const auto total = stress(D(), hn::Load(d, body.coupled_modulus.data() + volume), strain.tensor);
        store_stress(D(), without_faded(D(), at, total, volume), volume, at);
        hn::Store(strain.more, d, gain + lane);
    }
    if (!body.volume_stiffness.empty())
        set_gains(at, now, volume_slice, gain);
}

/// Pulls of a stress on the corners, inwards. An edge between corners m and n is under the tension -g_m . S g_n, an
/// edge from the first corner under what is left of g_m . S g_m; its direction has length l0.
/// @param stress  times the volume
template <class D>
HWY_INLINE OfCorners<D> pulls(D d, const OfFanEdges<Vec3<D>> &span, const OfCorners<D> &rest,
                              const OfFanEdges<hn::Vec<D>> &rest_length, const Symmetric<D> &stress) {
    const auto along_a = product<D>(stress, rest.a), along_b = product<D>(stress, rest.b),
               along_c = product<D>(stress, rest.c);
    const auto ab = dot(rest.a, along_b), bc = dot(rest.b, along_c), ca = dot(rest.c, along_a);
    const auto shorter = shortenings(d, span, rest_length);
    const auto along = [](const hn::Vec<D> &r, const hn::Vec<D> &m, const hn::Vec<D> &n, const hn::Vec<D> &l,
                          const Vec3<D> &x) HWY_ATTR { return scaled<D>(hn::Mul(r, hn::Add(m, hn::Add(n, l))), x); };
    const auto on_ab = scaled<D>(hn::Mul(shorter.ab, ab), span.ab);
    const auto on_bc = scaled<D>(hn::Mul(shorter.bc, bc), span.bc);
    const auto on_ca = scaled<D>(hn::Mul(shorter.ca, ca), span.ca);
    return {plus(along(shorter.a, dot(rest.a, along_a), ab, ca, span.a), minus(on_ab, on_ca)),
            plus(along(shorter.b, dot(rest.b, along_b), bc, ab, span.b), minus(on_bc, on_ab)),
            plus(along(shorter.c, dot(rest.c, along_c), ca, bc, span.c), minus(on_ca, on_bc))};
}

/// The forces of stresses, pressures and the guard on the nodes of the fans of a slice; see fan_forces().
template <class T> HWY_NOINLINE void nodal_spring_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const auto &faded = at.relaxation.tetrahedra.faded;
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto *rim_slot = slot + 2 * slice_size;
        FanWalk<false, T> fan(at, now, corner);
        const auto axis_stress = plus<D>(fetch_stress(D(), at, corner), fetch_stress(D(), at, corner + slice_size));
        auto from_stress = fetch_stress(D(), at, fan.corner);
        FanPulls<D> sums{D()};
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            fan.next();
            const auto to_stress = fetch_stress(D(), at, fan.corner);
            const auto around = plus<D>(axis_stress, plus<D>(from_stress, to_stress));
            auto inside = stress(D(), hn::Load(d, body.inner_modulus.data() + t),
                                 load_eight(D(), at.strain.data() + 8 * t).tensor);
            if (!faded.empty())
                inside = minus<D>(inside, load_six(D(), faded.data() + first_of_six(t)));
            const auto total = plus_scaled<D>(inside, hn::Load(d, body.rest_volume.data() + t), around);
            const auto pull = pulls(D(), edge_spans<D>(fan.axis.direction, fan.from.arm, fan.to.arm),
                                    rest_gradients(D(), body, t, lane), rest_lengths(D(), body, t, lane), total);

            const auto volume = fan.volume(at, now);
            const auto pressure = fan.pressure();
            const auto push = push_on(D(), body, pressure, volume, volume, t, largest);
            sums.add(D(), pull, push, fan.from, fan.to, at.corner_force, rim_slot);
            from_stress = to_stress;
        }
        sums.finish(D(), at.corner_force, slot, rim_slot);
    }
    largest.keep(D(), at, slice);
}

/// The means of Hooke's springs around nodes, from what nodal_strains() has put down.
template <class T> HWY_NOINLINE void relax_nodal_springs(StepWorkspace<T> &at, int volume_slice) {
    using D = Lanes<T>;
    HWY_ALIGN T sums[slice_size * 8];
    sum_of_strains(at, volume_slice, sums);
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const std::size_t volume = static_cast<std::size_t>(volume_slice) * slice_size + lane;
        const auto modulus = hn::Load(D(), at.body.coupled_modulus.data() + volume);
        relax_mean(D(), at, volume, deviatoric_stress(D(), modulus, load_eight(D(), sums + 8 * lane).tensor));
    }
}

/// Stresses inside the tetrahedra of a slice of fans, from the same.
template <class T> HWY_NOINLINE void relax_inner_springs(StepWorkspace<T> &at, int slice) {
    using D = Lanes<T>;
    auto &inside = at.relaxation.tetrahedra;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const FanLines lines(at.body, slice, lane);
        for (std::size_t t = lines.first; t < lines.end; t += slice_size) {
            const auto stress = deviatoric_stress(D(), hn::Load(D(), at.body.inner_modulus.data() + t),
                                                  load_eight(D(), at.strain.data() + 8 * t).tensor);
            const std::size_t first = first_of_six(t);
            store_six(D(), relax(D(), at.relaxation.shares, inside, first, stress), inside.faded.data() + first);
        }
    }
}

/// See StepFunctions::relax.
template <class T> void relax_hooke(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    const auto &fans = at.fan_slices[thread], &volumes = at.volume_slices[thread];
    for (int slice = fans.first; slice < fans.last; ++slice)
        nodal_strains<false>(at, now, slice);
    barrier.wait();
    for (int slice = volumes.first; slice < volumes.last; ++slice)
        relax_nodal_springs(at, slice);
    for (int slice = fans.first; slice < fans.last; ++slice)
        relax_inner_springs(at, slice);
}

/// See StepFunctions::stresses.
template <class T> void hooke_stresses(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    const auto [first, last] = at.volume_slices[thread];
    for (int slice = first; slice < last; ++slice)
        nodal_stresses(at, now, slice);
    barrier.wait();
}

template <class T> StepFunctions<T> hooke_steps(const SlicedBody<T> & /*body*/, bool is_damped) {
    return {.put_means = is_damped ? nodal_strains<true, T> : nodal_strains<false, T>,
            .stresses = hooke_stresses<T>,
            .fan_forces = nodal_spring_forces<T>,
            .relax = relax_hooke<T>};
}

/// W_s = mu ((tr E)^2 / 2 + E : E), and g = J - 1. Strains are given as G = 2 E. Steps take its stress from
/// stress() and deviatoric_stress() of vectors-inl.hpp.
template <class D> class Hooke {
  public:
    HWY_INLINE Hooke(D d, hn::Vec<D> modulus, const Symmetric<D> &twice_strain)
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

EquilibriumFunctions hooke_equilibrium(StrainMeasure /*measure*/) {
    return equilibrium_functions<Hooke, MeansOfElongations>();
}

EnergyFunctions hooke_functions() {
    EnergyFunctions functions{.steps = hooke_steps<float>, .equilibrium = hooke_equilibrium};
#if HWY_HAVE_FLOAT64
    functions.double_steps = hooke_steps<double>;
#endif
    return functions;
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::msm {

LIVERMARK_DISPATCH(EnergyFunctions hooke_kernels, hooke_functions, (), ())

} // namespace livermark::msm
#endif
