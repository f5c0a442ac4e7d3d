// Forces of springs that are coupled around nodes, for slices of fans of tetrahedra. Written once for each vector unit:
// see take_steps.cpp.
#if defined(LIVERMARK_NODAL_SPRINGS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_NODAL_SPRINGS_INL_HPP
#undef LIVERMARK_NODAL_SPRINGS_INL_HPP
#else
#define LIVERMARK_NODAL_SPRINGS_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/fan_forces-inl.hpp"
#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/symmetric-inl.hpp"

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

/// Gradients at rest of the barycentric coordinates of three corners of a tetrahedron.
template <class D> struct RestGradients { Vec3<D> end, from, to; };

/// @param t  place on the lines
template <class D, class T>
HWY_INLINE RestGradients<D> rest_gradients(D d, const SlicedBody<T> &body, std::size_t t, std::size_t lane) {
    const T *at = body.rest_gradient.data() + 9 * (t - lane) + lane;
    const auto load = [&](int k) HWY_ATTR { return hn::Load(d, at + k * slice_size); };
    return {{load(0), load(1), load(2)}, {load(3), load(4), load(5)}, {load(6), load(7), load(8)}};
}

/// Derivatives along x, y and z at rest of a field with these differences from the start of the axis.
template <class D>
HWY_INLINE Columns<D> derivatives(const Vec3<D> &end, const Vec3<D> &from, const Vec3<D> &to,
                                  const RestGradients<D> &rest) {
    const auto along = [&](const hn::Vec<D> &a, const hn::Vec<D> &b, const hn::Vec<D> &c)
                           HWY_ATTR { return plus_scaled<D>(plus_scaled<D>(scaled<D>(a, end), b, from), c, to); };
    return {along(rest.end.x, rest.from.x, rest.to.x), along(rest.end.y, rest.from.y, rest.to.y),
            along(rest.end.z, rest.from.z, rest.to.z)};
}

// These are functions of their own, so that the loops of bodies without such springs stay as they are.

/// Volume times the strain of each tetrahedron of the fans of a slice, and the volume that it has gained, with beta
/// times how fast they grow.
template <bool is_damped, class T> HWY_NOINLINE void nodal_strains(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const auto sixth = hn::Set(d, T(1.0 / 6.0)), half = hn::Set(d, T(0.5));
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
            const auto rest = rest_gradients(D(), body, t, lane);
            const auto slope = derivatives<D>(axis.direction, from.arm, to.arm, rest);
            auto strain = twice_strain(D(), slope);
            [[maybe_unused]] const auto before = rates;
            const auto volume = volume_between<is_damped>(D(), at, now, from, to, corner, rates);
            if constexpr (is_damped) {
                const auto growth = derivatives<D>(rates.axis, before.arm, rates.arm, rest);
                strain = plus_scaled<D>(strain, hn::Set(d, static_cast<T>(at.beta)), twice_product<D>(slope, growth));
            }
            const auto rest_volume = hn::Load(d, body.rest_volume.data() + t);
            store_eight(D(), {scaled<D>(hn::Mul(rest_volume, half), strain), hn::MulSub(volume, sixth, rest_volume)},
                        at.strain.data() + 8 * t);
            from = to;
        }
    }
}

/// A quarter of the stress around the nodes of 16 rows, from the strains of the tetrahedra there, and the pressures
/// there or what these are made of.
template <class T> HWY_NOINLINE void nodal_stresses(StepWorkspace<T> &at, int now, int volume_slice) {
    using D = Lanes<T>;
    constexpr D d;
    constexpr hn::CappedTag<T, 8> eight;
    const auto &body = at.body;
    HWY_ALIGN T sums[slice_size * 8];
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
    HWY_ALIGN T gain[slice_size];
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const auto strain = load_eight(D(), sums + 8 * lane);
        const std::size_t row = static_cast<std::size_t>(volume_slice) * slice_size + lane;
        const auto [xx, yy, zz, xy, yz, zx] =
            stress(D(), hn::Load(d, body.coupled_modulus.data() + row), strain.tensor);
        hn::StoreInterleaved4(xx, yy, zz, xy, d, at.stress[0].data() + 4 * row);
        hn::StoreInterleaved4(yz, zx, hn::Zero(d), hn::Zero(d), d, at.stress[1].data() + 4 * row);
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

/// Forces on three corners of a tetrahedron.
template <class D> struct CornerForces { Vec3<D> end, from, to; };

/// What a stress pulls the corners inwards with: F S times the gradients at rest.
/// @param stress  times the volume
template <class D>
HWY_INLINE CornerForces<D> pulls(const Vec3<D> &end, const Vec3<D> &from, const Vec3<D> &to,
                                 const RestGradients<D> &rest, const Symmetric<D> &stress) {
    // The gradients are taken to both sides of S first, which leaves a symmetric matrix between the corners.
    const auto of_end = product<D>(stress, rest.end), of_from = product<D>(stress, rest.from),
               of_to = product<D>(stress, rest.to);
    const auto end_from = dot(rest.end, of_from), from_to = dot(rest.from, of_to), to_end = dot(rest.to, of_end);
    const auto sum = [&](const hn::Vec<D> &a, const hn::Vec<D> &b, const hn::Vec<D> &c)
                         HWY_ATTR { return plus_scaled<D>(plus_scaled<D>(scaled<D>(a, end), b, from), c, to); };
    return {sum(dot(rest.end, of_end), end_from, to_end), sum(end_from, dot(rest.from, of_from), from_to),
            sum(to_end, from_to, dot(rest.to, of_to))};
}

/// The forces of stresses, pressures and the guard on the nodes of the fans of a slice; see fan_forces().
template <class T> HWY_NOINLINE void nodal_spring_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto axis = fetch_axis(D(), rows, corner);
        const auto axis_stress = plus<D>(fetch_stress(D(), at, corner), fetch_stress(D(), at, corner + slice_size));
        FanRates<false, D> rates;
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        auto from_stress = fetch_stress(D(), at, corner);
        const auto zero = hn::Zero(d);
        Vec3<D> before{zero, zero, zero}, on_rim = before, on_end = before;
        const auto *rim_slot = slot + 2 * slice_size;
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto to_stress = fetch_stress(D(), at, corner);
            const auto around = plus<D>(axis_stress, plus<D>(from_stress, to_stress));
            const auto inside = stress(D(), hn::Load(d, body.inner_modulus.data() + t),
                                       load_eight(D(), at.strain.data() + 8 * t).tensor);
            const auto total = plus_scaled<D>(inside, hn::Load(d, body.rest_volume.data() + t), around);
            const auto pull = pulls<D>(axis.direction, from.arm, to.arm, rest_gradients(D(), body, t, lane), total);

            const auto volume = volume_between<false>(D(), at, now, from, to, corner, rates);
            const auto pressure = hn::Add(axis.pressure, hn::Add(from.pressure, to.pressure));
            const auto push = push_on(D(), body, pressure, volume, volume, t);
            const auto force = minus(before, plus_scaled<D>(pull.from, push, to.lever));
            add_force(D(), force, at.corner_force, rim_slot);
            on_rim = plus(on_rim, force);
            on_end = plus(on_end, minus(scaled<D>(push, cross(from.arm, to.arm)), pull.end));
            before = minus(scaled<D>(push, from.lever), pull.to);
            from = to;
            from_stress = to_stress;
        }
        add_force(D(), before, at.corner_force, rim_slot);
        add_force(D(), on_end, at.corner_force, slot + slice_size);
        const Vec3<D> nothing{zero, zero, zero};
        add_force(D(), minus(nothing, plus(plus(on_rim, before), on_end)), at.corner_force, slot);
    }
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_NODAL_SPRINGS_INL_HPP
