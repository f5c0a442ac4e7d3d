// Forces of volumes, for slices of fans of tetrahedra. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_FAN_FORCES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_FAN_FORCES_INL_HPP
#undef LIVERMARK_FAN_FORCES_INL_HPP
#else
#define LIVERMARK_FAN_FORCES_INL_HPP
#endif

#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// What a fan of tetrahedra turns around.
template <class D> struct Axis {
    Rows<D> start;
    Vec3<D> direction;
    hn::Vec<D> pressure; ///< sum over both ends
};

/// A node of its rim.
template <class D> struct RimNode {
    Vec3<D> arm;   ///< from the start of the axis
    Vec3<D> lever; ///< axis x arm: six times the gradient of the volume at the next node
    hn::Vec<D> pressure;
};

template <class D, class T> HWY_INLINE Axis<D> fetch_axis(D d, const T *rows, const std::int32_t *corner) {
    const auto start = fetch(d, rows, corner), end = fetch(d, rows, corner + slice_size);
    return {start, difference(end, start), hn::Add(start.w, end.w)};
}

template <class D, class T>
HWY_INLINE RimNode<D> fetch_rim(D d, const Axis<D> &axis, const T *rows, const std::int32_t *corner) {
    const auto node = fetch(d, rows, corner);
    const auto arm = difference(node, axis.start);
    return {arm, cross(axis.direction, arm), node.w};
}

/// The velocities of a fan, where they matter.
template <bool is_damped, class D> struct FanRates {
    template <class T>
    HWY_INLINE void begin(D /*d*/, const StepWorkspace<T> & /*at*/, int /*now*/, const std::int32_t * /*corner*/) {}
};
template <class D> struct FanRates<true, D> {
    Rows<D> start;
    Vec3<D> axis, arm;

    template <class T> HWY_INLINE void begin(D d, const StepWorkspace<T> &at, int now, const std::int32_t *corner) {
        const T *velocities = at.velocity_rows[now].data();
        start = fetch(d, velocities, corner);
        axis = difference(fetch(d, velocities, corner + slice_size), start);
        arm = difference(fetch(d, velocities, corner + 2 * slice_size), start);
    }
};

/// Six times the volume between two nodes of the rim, and beta times how fast it grows.
template <bool is_damped, class D, class T>
HWY_INLINE hn::Vec<D> volume_between(D d, const StepWorkspace<T> &at, [[maybe_unused]] int now, const RimNode<D> &from,
                                     const RimNode<D> &to, const std::int32_t *corner_of_to,
                                     FanRates<is_damped, D> &rates) {
    auto volume = dot(from.lever, to.arm);
    if constexpr (is_damped) {
        const auto next = difference(fetch(d, at.velocity_rows[now].data(), corner_of_to), rates.start);
        const auto growth =
            hn::Add(hn::Sub(dot(from.lever, next), dot(to.lever, rates.arm)), dot(cross(from.arm, to.arm), rates.axis));
        volume = hn::MulAdd(hn::Set(d, static_cast<T>(at.beta)), growth, volume);
        rates.arm = next;
    }
    return volume;
}

/// Where the fans of a slice have their numbers.
struct FanLines {
    std::size_t corner, first, end; ///< of the start of the axis, of the first tetrahedron, and behind the last

    template <class T>
    FanLines(const SlicedBody<T> &body, int slice, std::size_t lane)
        : corner(static_cast<std::size_t>(body.fan_start[slice] + 3 * slice) * slice_size + lane),
          first(static_cast<std::size_t>(body.fan_start[slice]) * slice_size + lane),
          end(static_cast<std::size_t>(body.fan_start[slice + 1]) * slice_size) {}
};

/// A number of the tetrahedra of a fan, put down at its corners as sums over those that meet there.
template <class D> struct CornerSum {
    hn::Vec<D> before, sum;
    HWY_INLINE explicit CornerSum(D d) : before(hn::Zero(d)), sum(before) {}

    template <class T> HWY_INLINE void add(D d, hn::Vec<D> value, T *rim) {
        hn::Store(hn::Add(before, value), d, rim);
        sum = hn::Add(sum, value);
        before = value;
    }
    template <class T> HWY_INLINE void finish(D d, T *axis, T *last_rim) const {
        hn::Store(before, d, last_rim);
        hn::Store(sum, d, axis);
        hn::Store(sum, d, axis + slice_size);
    }
};

/// Of control volumes of a slice, those from `lane` on, the sum over the corners of fans there.
/// @param values  of each corner
template <class D, class T>
HWY_INLINE hn::Vec<D> sum_at_corners(D d, const SlicedBody<T> &body, const Aligned<T> &values, int volume_slice,
                                     std::size_t lane) {
    const std::size_t first = static_cast<std::size_t>(body.volume_start[volume_slice]) * slice_size + lane;
    const std::size_t end = static_cast<std::size_t>(body.volume_start[volume_slice + 1]) * slice_size;
    HWY_ALIGN T sums[hn::MaxLanes(D())];
    // One by one, which takes half as long as the machine's gather; four at once, because each waits for the one
    // before.
    constexpr std::size_t at_once = hn::MaxLanes(D()) < 4 ? hn::MaxLanes(D()) : 4;
    for (std::size_t i = 0; i < hn::Lanes(d); i += at_once) {
        T sum[at_once] = {};
        for (std::size_t m = first + i; m < end; m += slice_size)
            for (std::size_t k = 0; k < at_once; ++k)
                sum[k] += values[static_cast<std::size_t>(body.member[m + k])];
        std::copy_n(sum, at_once, sums + i);
    }
    return hn::Load(d, sums);
}

/// Puts the pressures of 16 control volumes into their rows.
template <class T> HWY_INLINE void set_pressures(StepWorkspace<T> &at, int now, int slice, const T *pressure) {
    const int *row = at.body.volume_row.data() + static_cast<std::ptrdiff_t>(slice) * slice_size;
    for (int i = 0; i < slice_size; ++i)
        at.rows[now][4 * static_cast<std::size_t>(row[i]) + 3] = pressure[i];
}

/// Makes a quarter of the pressures in 16 control volumes of what the tetrahedra there have gained.
template <class T> HWY_INLINE void set_gains(StepWorkspace<T> &at, int now, int slice, const T *gain) {
    constexpr Lanes<T> d;
    const std::size_t first = static_cast<std::size_t>(slice) * slice_size;
    HWY_ALIGN T pressure[slice_size];
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d))
        hn::Store(hn::Mul(hn::Mul(hn::Load(d, gain + lane), hn::Set(d, T(0.25))),
                          hn::Load(d, at.body.volume_stiffness.data() + first + lane)),
                  d, pressure + lane);
    set_pressures(at, now, slice, pressure);
}

/// A quarter of the pressure in 16 control volumes, into their rows.
template <class T> HWY_INLINE void pressures(StepWorkspace<T> &at, int now, int volume_slice) {
    using D = Lanes<T>;
    constexpr D d;
    HWY_ALIGN T gain[slice_size];
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d))
        hn::Store(sum_at_corners(D(), at.body, at.gain, volume_slice, lane), d, gain + lane);
    set_gains(at, now, volume_slice, gain);
}

/// The most that tetrahedra of a slice of fans lack of the volumes that are watched: see StepWorkspace::deficit.
template <class D> struct LargestDeficit {
    hn::Vec<D> deficit;
    HWY_INLINE explicit LargestDeficit(D d) : deficit(hn::Zero(d)) {}

    /// @param watched  0 where nothing is
    HWY_INLINE void see(D d, hn::Vec<D> watched, hn::Vec<D> volume) {
        deficit = hn::Max(deficit, hn::IfThenElseZero(hn::Gt(watched, hn::Zero(d)), hn::Sub(watched, volume)));
    }
    /// @param slice  index into StepWorkspace::deficit
    template <class T> HWY_INLINE void keep(D d, StepWorkspace<T> &at, int slice) const {
        if (!at.deficit.empty())
            at.deficit[static_cast<std::size_t>(slice)] = hn::GetLane(hn::MaxOfLanes(d, deficit));
    }
};

/// What pushes the corners of tetrahedra outwards because of their own volume: their pressures, and the guard against
/// inversion.
/// @param volume   six times the volume, with what damps it
/// @param plain    six times the volume
/// @param t        place on the lines
/// @param largest  told what the guard sees
template <class D, class T>
HWY_INLINE hn::Vec<D> push_of_volume(D d, const SlicedBody<T> &body, hn::Vec<D> volume, hn::Vec<D> plain, std::size_t t,
                                     LargestDeficit<D> &largest) {
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    auto push = hn::Zero(d);
    if (!body.tetrahedron_stiffness.empty()) {
        const auto gain = hn::MulSub(volume, sixth, hn::Load(d, body.rest_volume.data() + t));
        push = hn::NegMulAdd(hn::Load(d, body.tetrahedron_stiffness.data() + t), gain, push);
    }
    if (!body.guard_stiffness.empty()) {
        const auto least = hn::Load(d, body.least_volume.data() + t);
        if (!body.watched_volume.empty())
            largest.see(d, hn::Load(d, body.watched_volume.data() + t), hn::Mul(plain, sixth));
        const auto deficit = hn::Max(hn::NegMulAdd(plain, sixth, least), hn::Zero(d));
        push = hn::MulAdd(hn::Load(d, body.guard_stiffness.data() + t), deficit, push);
    }
    return push;
}

/// The same with the pressures around the nodes.
/// @param pressure  sum over the corners
/// @return a sixth of the push
template <class D, class T>
HWY_INLINE hn::Vec<D> push_on(D d, const SlicedBody<T> &body, hn::Vec<D> pressure, hn::Vec<D> volume, hn::Vec<D> plain,
                              std::size_t t, LargestDeficit<D> &largest) {
    auto push = push_of_volume(d, body, volume, plain, t, largest);
    if (!body.volume_stiffness.empty())
        push = hn::NegMulAdd(pressure, hn::Load(d, body.volume_share.data() + t), push);
    return hn::Mul(push, hn::Set(d, T(1.0 / 6.0)));
}

template <class D, class T>
HWY_INLINE void add_force(D d, const Vec3<D> &force, Aligned<T> &forces, const std::int32_t *slot) {
    scatter_add(d, force.x, force.y, force.z, forces.data(), slot);
}

/// What they do to the nodes of the fans of a slice. Each node of a rim gets one force from the tetrahedra before and
/// after it; the forces of a tetrahedron have no resultant, so the start of the axis gets what is left.
template <bool is_damped, class T> HWY_INLINE void fan_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto *slot = body.force_slot.data() + lines.corner;
        const auto axis = fetch_axis(D(), rows, corner);
        FanRates<is_damped, D> rates;
        rates.begin(d, at, now, corner);
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        const auto zero = hn::Zero(d);
        Vec3<D> before{zero, zero, zero}, on_rim = before, on_end = before;
        const auto *rim_slot = slot + 2 * slice_size;
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto volume = volume_between<is_damped>(D(), at, now, from, to, corner, rates);
            const auto plain = is_damped ? dot(from.lever, to.arm) : volume;
            const auto pressure = hn::Add(axis.pressure, hn::Add(from.pressure, to.pressure));
            const auto push = push_on(D(), body, pressure, volume, plain, t, largest);
            const auto force = minus(before, scaled<D>(push, to.lever));
            add_force(D(), force, at.corner_force, rim_slot);
            on_rim = plus(on_rim, force);
            on_end = plus(on_end, scaled<D>(push, cross(from.arm, to.arm)));
            before = scaled<D>(push, from.lever);
            from = to;
        }
        add_force(D(), before, at.corner_force, rim_slot);
        add_force(D(), on_end, at.corner_force, slot + slice_size);
        const Vec3<D> nothing{zero, zero, zero};
        add_force(D(), minus(nothing, plus(plus(on_rim, before), on_end)), at.corner_force, slot);
    }
    largest.keep(D(), at, slice);
}

/// The same with what the tetrahedra have given to nodes of a slice, those from `lane` on.
template <class D, class T>
HWY_INLINE Vec3<D> plus_corner_forces(D d, const StepWorkspace<T> &at, int slice, std::size_t lane, Vec3<D> force) {
    const auto &body = at.body;
    const std::size_t end = static_cast<std::size_t>(body.sum_start[slice + 1]) * slice_size;
    const auto zero = hn::Zero(d);
    Blocks<D> sum{zero, zero, zero, zero};
    for (std::size_t s = static_cast<std::size_t>(body.sum_start[slice]) * slice_size + lane; s < end; s += slice_size)
        sum = plus<D>(sum, fetch_blocks(d, at.corner_force.data(), body.sum.data() + s));
    const auto of_fans = transposed<D>(d, sum);
    return plus(force, Vec3<D>{of_fans.x, of_fans.y, of_fans.z});
}

// What stresses do to fans of tetrahedra.

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

/// The stress of a mean without what has relaxed of it.
/// @param mean  number of the control volume or star
template <class D, class T>
HWY_INLINE Symmetric<D> without_faded(D d, const StepWorkspace<T> &at, const Symmetric<D> &stress, std::size_t mean) {
    const auto &faded = at.relaxation.means.faded;
    return faded.empty() ? stress : minus<D>(stress, load_six(d, faded.data() + first_of_six(mean)));
}

/// Adds up what tetrahedra do to the nodes of their fan; see fan_forces().
template <class D> struct FanPulls {
    Vec3<D> before, on_rim, on_end; ///< inwards

    HWY_INLINE explicit FanPulls(D d) : before{hn::Zero(d), hn::Zero(d), hn::Zero(d)}, on_rim(before), on_end(before) {}

    /// @param pull  of stresses, on the corners inwards
    /// @param push  a sixth of what pushes them outwards
    /// @param slot  of the node between this tetrahedron and the one before
    template <class T>
    HWY_INLINE void add(D d, const OfCorners<D> &pull, hn::Vec<D> push, const RimNode<D> &from, const RimNode<D> &to,
                        Aligned<T> &forces, const std::int32_t *slot) {
        const auto on_from = plus(before, plus_scaled<D>(pull.b, push, to.lever));
        add_force(d, outwards(d, on_from), forces, slot);
        on_rim = plus(on_rim, on_from);
        on_end = plus(on_end, minus(pull.a, scaled<D>(push, cross(from.arm, to.arm))));
        before = minus(pull.c, scaled<D>(push, from.lever));
    }

    /// @param slot       of the start of the axis
    /// @param last_slot  of the last node of the rim
    template <class T>
    HWY_INLINE void finish(D d, Aligned<T> &forces, const std::int32_t *slot, const std::int32_t *last_slot) const {
        add_force(d, outwards(d, before), forces, last_slot);
        add_force(d, outwards(d, on_end), forces, slot + slice_size);
        add_force(d, plus(plus(on_rim, before), on_end), forces, slot);
    }

  private:
    HWY_INLINE static Vec3<D> outwards(D d, const Vec3<D> &pull) {
        const auto zero = hn::Zero(d);
        return minus(Vec3<D>{zero, zero, zero}, pull);
    }
};

// Gradient, strain and stress of tetrahedra in which displacements are linear.

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

/// What a stress pulls the corners inwards with, P g of each.
/// @param p  first stress of Piola and Kirchhoff, times the volume
template <class D> HWY_INLINE OfCorners<D> pulls(const Columns<D> &p, const OfCorners<D> &rest) {
    const auto along = [&](const Vec3<D> &g) HWY_ATTR { return combined<D>(g.x, p.x, g.y, p.y, g.z, p.z); };
    return {along(rest.a), along(rest.b), along(rest.c)};
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_FAN_FORCES_INL_HPP
