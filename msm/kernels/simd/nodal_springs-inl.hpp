// Forces of springs that are coupled around nodes, for slices of fans of tetrahedra. Written once for each vector unit:
// see take_steps.cpp.
#if defined(LIVERMARK_NODAL_SPRINGS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_NODAL_SPRINGS_INL_HPP
#undef LIVERMARK_NODAL_SPRINGS_INL_HPP
#else
#define LIVERMARK_NODAL_SPRINGS_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/simd/fan_forces-inl.hpp"
#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Places of rows of eight numbers behind each other.
inline constexpr std::int32_t rows_of_eight[slice_size] = {0,  8,  16, 24, 32, 40,  48,  56,
                                                           64, 72, 80, 88, 96, 104, 112, 120};

/// A strain or a stress, and another number, from eight numbers behind each other.
template <class D> struct SymmetricAndMore {
    Symmetric<D> tensor;
    hn::Vec<D> more;
};
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
template <class V> struct OfEdges { V a, b, c, ab, bc, ca; };

/// Lengths at rest.
/// @param t  place on the lines
template <class D, class T>
HWY_INLINE OfEdges<hn::Vec<D>> rest_lengths(D d, const SlicedBody<T> &body, std::size_t t, std::size_t lane) {
    const T *at = body.rest_length.data() + 6 * (t - lane) + lane;
    const auto load = [&](int k) HWY_ATTR { return hn::Load(d, at + k * slice_size); };
    return {load(0), load(1), load(2), load(3), load(4), load(5)};
}

template <class D> HWY_INLINE OfEdges<Vec3<D>> edge_spans(const Vec3<D> &a, const Vec3<D> &b, const Vec3<D> &c) {
    return {a, b, c, minus(b, a), minus(c, b), minus(a, c)};
}

/// Length at rest over length.
template <class D> HWY_INLINE hn::Vec<D> shortening(D d, const Vec3<D> &span, hn::Vec<D> rest_length) {
    const auto square = squared_length(d, span);
    return hn::Mul(rest_length, refined(d, square, guess_of_inverse_root(d, square)));
}
template <class D>
HWY_INLINE OfEdges<hn::Vec<D>> shortenings(D d, const OfEdges<Vec3<D>> &span, const OfEdges<hn::Vec<D>> &rest) {
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
HWY_INLINE OfEdges<hn::Vec<D>> half_stretches(D d, const OfEdges<Vec3<D>> &span, const OfEdges<hn::Vec<D>> &rest) {
    return {half_stretch(d, span.a, rest.a),   half_stretch(d, span.b, rest.b),   half_stretch(d, span.c, rest.c),
            half_stretch(d, span.ab, rest.ab), half_stretch(d, span.bc, rest.bc), half_stretch(d, span.ca, rest.ca)};
}

/// beta times how fast half the stretches grow.
template <class D>
HWY_INLINE OfEdges<hn::Vec<D>> plus_rates(const OfEdges<hn::Vec<D>> &stretch, hn::Vec<D> beta,
                                          const OfEdges<hn::Vec<D>> &shortening, const OfEdges<Vec3<D>> &span,
                                          const OfEdges<Vec3<D>> &rate) {
    const auto grown = [&](const hn::Vec<D> &s, const hn::Vec<D> &r, const Vec3<D> &x, const Vec3<D> &v)
                           HWY_ATTR { return hn::MulAdd(hn::Mul(beta, r), dot(x, v), s); };
    return {grown(stretch.a, shortening.a, span.a, rate.a),     grown(stretch.b, shortening.b, span.b, rate.b),
            grown(stretch.c, shortening.c, span.c, rate.c),     grown(stretch.ab, shortening.ab, span.ab, rate.ab),
            grown(stretch.bc, shortening.bc, span.bc, rate.bc), grown(stretch.ca, shortening.ca, span.ca, rate.ca)};
}

/// E = sum over corners m, n but the first of A_mn g_m g_n^T, where A_mm is half the stretch from the first corner and
/// 2 A_mn = A_mm + A_nn - half the stretch between m and n: what the law of cosines makes of
/// E = -1/4 sum over edges of q (g g^T + g g^T).
template <class D> HWY_INLINE Symmetric<D> strain_of(D d, const OfEdges<hn::Vec<D>> &half, const OfCorners<D> &rest) {
    const auto between = [&](const hn::Vec<D> &m, const hn::Vec<D> &n, const hn::Vec<D> &edge)
                             HWY_ATTR { return hn::Mul(hn::Set(d, hn::TFromD<D>(0.5)), hn::Sub(hn::Add(m, n), edge)); };
    const auto ab = between(half.a, half.b, half.ab), bc = between(half.b, half.c, half.bc),
               ca = between(half.c, half.a, half.ca);
    const auto of_a = combined<D>(half.a, rest.a, ab, rest.b, ca, rest.c);
    const auto of_b = combined<D>(ab, rest.a, half.b, rest.b, bc, rest.c);
    const auto of_c = combined<D>(ca, rest.a, bc, rest.b, half.c, rest.c);
    const auto sum = [](const hn::Vec<D> &xa, const hn::Vec<D> &ya, const hn::Vec<D> &xb, const hn::Vec<D> &yb,
                        const hn::Vec<D> &xc, const hn::Vec<D> &yc)
                         HWY_ATTR { return hn::MulAdd(xa, ya, hn::MulAdd(xb, yb, hn::Mul(xc, yc))); };
    return {sum(rest.a.x, of_a.x, rest.b.x, of_b.x, rest.c.x, of_c.x),
            sum(rest.a.y, of_a.y, rest.b.y, of_b.y, rest.c.y, of_c.y),
            sum(rest.a.z, of_a.z, rest.b.z, of_b.z, rest.c.z, of_c.z),
            sum(rest.a.x, of_a.y, rest.b.x, of_b.y, rest.c.x, of_c.y),
            sum(rest.a.y, of_a.z, rest.b.y, of_b.z, rest.c.y, of_c.z),
            sum(rest.a.z, of_a.x, rest.b.z, of_b.x, rest.c.z, of_c.x)};
}

// These are functions of their own, so that the loops of bodies without such springs stay as they are.

/// Volume times the strain of each tetrahedron of the fans of a slice, and the volume that it has gained, with beta
/// times how fast they grow.
template <bool is_damped, class T> HWY_NOINLINE void nodal_strains(StepWorkspace<T> &at, int now, int slice) {
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
        for (std::size_t t = lines.first; t < lines.end; t += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto rest_length = rest_lengths(D(), body, t, lane);
            const auto span = edge_spans<D>(axis.direction, from.arm, to.arm);
            auto half = half_stretches(D(), span, rest_length);
            [[maybe_unused]] const auto before = rates;
            const auto volume = hn::Mul(hn::Load(d, body.volume_share.data() + t),
                                        volume_between<is_damped>(D(), at, now, from, to, corner, rates));
            if constexpr (is_damped)
                half = plus_rates<D>(half, hn::Set(d, static_cast<T>(at.beta)), shortenings(D(), span, rest_length),
                                     span, edge_spans<D>(rates.axis, before.arm, rates.arm));
            const auto rest_volume = hn::Load(d, body.rest_volume.data() + t);
            store_eight(D(),
                        {scaled<D>(rest_volume, strain_of(D(), half, rest_gradients(D(), body, t, lane))),
                         hn::MulSub(volume, sixth, rest_volume)},
                        at.strain.data() + 8 * t);
            from = to;
        }
    }
}

/// Puts stresses down in the rows of control volumes behind each other, where fetch_stress() finds them.
template <class D, class T>
HWY_INLINE void store_stress(D d, const Symmetric<D> &stress, std::size_t first_volume, StepWorkspace<T> &at) {
    HWY_ALIGN std::array<T, 4 * slice_size> first_four, other_two;
    const auto &[xx, yy, zz, xy, yz, zx] = stress;
    hn::StoreInterleaved4(xx, yy, zz, xy, d, first_four.data());
    hn::StoreInterleaved4(yz, zx, hn::Zero(d), hn::Zero(d), d, other_two.data());
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
        const auto row = 4 * static_cast<std::size_t>(at.body.volume_row[first_volume + i]);
        std::copy_n(first_four.data() + 4 * i, 4, at.stress[0].data() + row);
        std::copy_n(other_two.data() + 4 * i, 4, at.stress[1].data() + row);
    }
}

/// Of 16 control volumes, the sums over their tetrahedra of what nodal_strains() puts down.
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

/// What a node of a fan has beside its place.
template <class D, class T>
HWY_INLINE Symmetric<D> fetch_stress(D d, const StepWorkspace<T> &at, const std::int32_t *corner) {
    const auto a = fetch(d, at.stress[0].data(), corner), b = fetch(d, at.stress[1].data(), corner);
    return {a.x, a.y, a.z, a.w, b.x, b.y};
}

/// What a stress pulls the corners inwards with. An edge between corners m and n is under the tension -g_m . S g_n, an
/// edge from the first corner under what is left of g_m . S g_m; its direction has length l0.
/// @param stress  times the volume
template <class D>
HWY_INLINE OfCorners<D> pulls(D d, const OfEdges<Vec3<D>> &span, const OfCorners<D> &rest,
                              const OfEdges<hn::Vec<D>> &rest_length, const Symmetric<D> &stress) {
    const auto of_a = product<D>(stress, rest.a), of_b = product<D>(stress, rest.b), of_c = product<D>(stress, rest.c);
    const auto ab = dot(rest.a, of_b), bc = dot(rest.b, of_c), ca = dot(rest.c, of_a);
    const auto shorter = shortenings(d, span, rest_length);
    const auto along = [](const hn::Vec<D> &r, const hn::Vec<D> &m, const hn::Vec<D> &n, const hn::Vec<D> &l,
                          const Vec3<D> &x) HWY_ATTR { return scaled<D>(hn::Mul(r, hn::Add(m, hn::Add(n, l))), x); };
    const auto on_ab = scaled<D>(hn::Mul(shorter.ab, ab), span.ab);
    const auto on_bc = scaled<D>(hn::Mul(shorter.bc, bc), span.bc);
    const auto on_ca = scaled<D>(hn::Mul(shorter.ca, ca), span.ca);
    return {plus(along(shorter.a, dot(rest.a, of_a), ab, ca, span.a), minus(on_ab, on_ca)),
            plus(along(shorter.b, dot(rest.b, of_b), bc, ab, span.b), minus(on_bc, on_ab)),
            plus(along(shorter.c, dot(rest.c, of_c), ca, bc, span.c), minus(on_ca, on_bc))};
}

/// The forces of stresses, pressures and the guard on the nodes of the fans of a slice; see fan_forces().
template <class T> HWY_NOINLINE void nodal_spring_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const auto &faded = at.relaxation.tetrahedra.faded;
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto *rim_slot = slot + 2 * slice_size;
        const auto axis = fetch_axis(D(), rows, corner);
        const auto axis_stress = plus<D>(fetch_stress(D(), at, corner), fetch_stress(D(), at, corner + slice_size));
        FanRates<false, D> rates;
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        auto from_stress = fetch_stress(D(), at, corner);
        FanPulls<D> sums{D()};
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto to_stress = fetch_stress(D(), at, corner);
            const auto around = plus<D>(axis_stress, plus<D>(from_stress, to_stress));
            auto inside = stress(D(), hn::Load(d, body.inner_modulus.data() + t),
                                 load_eight(D(), at.strain.data() + 8 * t).tensor);
            if (!faded.empty())
                inside = minus<D>(inside, load_six(D(), faded.data() + first_of_six(t)));
            const auto total = plus_scaled<D>(inside, hn::Load(d, body.rest_volume.data() + t), around);
            const auto pull = pulls(D(), edge_spans<D>(axis.direction, from.arm, to.arm),
                                    rest_gradients(D(), body, t, lane), rest_lengths(D(), body, t, lane), total);

            const auto volume = volume_between<false>(D(), at, now, from, to, corner, rates);
            const auto pressure = hn::Add(axis.pressure, hn::Add(from.pressure, to.pressure));
            const auto push = push_on(D(), body, pressure, volume, volume, t, largest);
            sums.add(D(), pull, push, from, to, at.corner_force, rim_slot);
            from = to;
            from_stress = to_stress;
        }
        sums.finish(D(), at.corner_force, slot, rim_slot);
    }
    largest.keep(D(), at, slice);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_NODAL_SPRINGS_INL_HPP
