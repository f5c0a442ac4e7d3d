// Forces of volumes, for slices of fans of tetrahedra. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_FAN_FORCES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_FAN_FORCES_INL_HPP
#undef LIVERMARK_FAN_FORCES_INL_HPP
#else
#define LIVERMARK_FAN_FORCES_INL_HPP
#endif

#include <algorithm>
#include <type_traits>

#include "msm/kernels/simd/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Edge that a fan of tetrahedra turns around.
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

/// Walk from node to node of the rims of fans side by side.
template <bool is_damped, class T> struct FanWalk {
    using D = Lanes<T>;

    const T *rows;
    const std::int32_t *corner; ///< of the next node
    Axis<D> axis;
    FanRates<is_damped, D> rates;
    RimNode<D> from, to;

    /// @param start  of the axis
    HWY_INLINE FanWalk(const StepWorkspace<T> &at, int now, const std::int32_t *start)
        : rows(at.rows[now].data()), corner(start + 2 * slice_size), axis(fetch_axis(D(), rows, start)) {
        rates.begin(D(), at, now, start);
        to = fetch_rim(D(), axis, rows, corner);
    }
    HWY_INLINE void next() {
        from = to;
        corner += slice_size;
        to = fetch_rim(D(), axis, rows, corner);
    }
    HWY_INLINE hn::Vec<D> pressure() const { return hn::Add(axis.pressure, hn::Add(from.pressure, to.pressure)); }

    /// Six times the volume between both nodes, and beta times how fast it grows.
    HWY_INLINE hn::Vec<D> volume(const StepWorkspace<T> &at, [[maybe_unused]] int now) {
        auto result = dot(from.lever, to.arm);
        if constexpr (is_damped) {
            const auto arm = difference(fetch(D(), at.velocity_rows[now].data(), corner), rates.start);
            const auto growth = hn::Add(hn::Sub(dot(from.lever, arm), dot(to.lever, rates.arm)),
                                        dot(cross(from.arm, to.arm), rates.axis));
            result = hn::MulAdd(hn::Set(D(), static_cast<T>(at.beta)), growth, result);
            rates.arm = arm;
        }
        return result;
    }
};

/// Places of the numbers of the fans of a slice.
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

/// Sum over the corners of fans in control volumes of a slice, those from `lane` on.
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
    /// A mean that springs are coupled by: how much det C lacks of what makes the trace of C^-1 four.
    HWY_INLINE void see(D d, const CauchyGreen<D> &of) {
        using T = hn::TFromD<D>;
        const auto wanted = hn::MulSub(hn::Set(d, T(0.25)), of.adjugate_trace, hn::Set(d, T(1)));
        deficit = hn::Max(deficit, hn::Sub(wanted, of.exact_change));
    }
    /// @param slice  index into StepWorkspace::deficit
    template <class T> HWY_INLINE void keep(D d, StepWorkspace<T> &at, int slice) const {
        if (!at.deficit.empty())
            at.deficit[static_cast<std::size_t>(slice)] = hn::GetLane(hn::MaxOfLanes(d, deficit));
    }
};

/// Push on the corners of tetrahedra, outwards, because of their own volume: their pressures, and the guard against
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

/// Puts down a sixth of what pushes the corners of tetrahedra outwards because of their volume: the guard, and springs
/// inside, of which mu F pulls, see Energy::push_inside().
/// @param volume   six times the volume
/// @param t        place on the lines
/// @param largest  told what the guard sees
template <template <class> class Energy, class D, class T>
HWY_INLINE void put_push_inside(D d, StepWorkspace<T> &at, hn::Vec<D> volume, std::size_t t,
                                LargestDeficit<D> &largest) {
    const auto &body = at.body;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    const auto least = hn::Set(d, static_cast<T>(std::max(1e-12, at.least_stretch * at.least_stretch)));
    // What fills up a fan has no volume.
    const auto rest_volume = hn::Max(hn::Load(d, body.rest_volume.data() + t), hn::Set(d, T(1e-30)));
    const auto j = hn::Div(hn::Mul(volume, sixth), rest_volume);
    const auto spring_push = Energy<D>::push_inside(d, j, hn::Max(hn::Mul(j, j), least));
    const auto push = hn::MulAdd(hn::Load(d, body.volume_modulus.data() + t), spring_push,
                                 push_of_volume(d, body, volume, volume, t, largest));
    hn::Store(hn::Mul(sixth, push), d, at.push.data() + t);
}

/// Volumes without springs that are coupled.
template <class D> struct NoEnergy {};

/// Volume that the tetrahedra at each corner of the fans of a slice have gained, and beta times how fast they do.
/// @tparam Energy  of springs with means of F around nodes: then rates stay apart, and the push of springs inside is
///                 put down; NoEnergy without such springs
template <bool is_damped, template <class> class Energy, class T>
HWY_NOINLINE void volume_gains(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    constexpr bool has_energy = !std::is_same_v<Energy<D>, NoEnergy<D>>;
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        FanWalk<is_damped, T> fan(at, now, body.corner.data() + lines.corner);
        CornerSum<D> gains{D()};
        [[maybe_unused]] CornerSum<D> growth{D()};
        std::size_t rim = lines.corner + 2 * slice_size;
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim += slice_size) {
            fan.next();
            const auto share = hn::Load(d, body.volume_share.data() + t);
            auto volume = hn::Mul(share, fan.volume(at, now));
            if constexpr (is_damped && has_energy) {
                const auto plain = hn::Mul(share, dot(fan.from.lever, fan.to.arm));
                growth.add(D(), hn::Mul(hn::Sub(volume, plain), sixth), at.gain_rate.data() + rim);
                volume = plain;
            }
            if constexpr (has_energy)
                put_push_inside<Energy>(D(), at, volume, t, largest);
            gains.add(D(), hn::MulSub(volume, sixth, hn::Load(d, body.rest_volume.data() + t)), at.gain.data() + rim);
        }
        gains.finish(D(), at.gain.data() + lines.corner, at.gain.data() + rim);
        if constexpr (is_damped && has_energy)
            growth.finish(D(), at.gain_rate.data() + lines.corner, at.gain_rate.data() + rim);
    }
    if constexpr (has_energy)
        largest.keep(D(), at, slice);
}

template <class D, class T>
HWY_INLINE void add_force(D d, const Vec3<D> &force, Aligned<T> &forces, const std::int32_t *slot) {
    scatter_add(d, force.x, force.y, force.z, forces.data(), slot);
}

/// Forces on the nodes of the fans of a slice. Each node of a rim gets one force from the tetrahedra before and
/// after it; the forces of a tetrahedron have no resultant, so the start of the axis gets what is left.
template <bool is_damped, class T> HWY_INLINE void fan_forces(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *slot = body.force_slot.data() + lines.corner;
        FanWalk<is_damped, T> fan(at, now, body.corner.data() + lines.corner);
        const auto zero = hn::Zero(d);
        Vec3<D> before{zero, zero, zero}, on_rim = before, on_end = before;
        const auto *rim_slot = slot + 2 * slice_size;
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim_slot += slice_size) {
            fan.next();
            const auto volume = fan.volume(at, now);
            const auto plain = is_damped ? dot(fan.from.lever, fan.to.arm) : volume;
            const auto pressure = fan.pressure();
            const auto push = push_on(D(), body, pressure, volume, plain, t, largest);
            const auto force = minus(before, scaled<D>(push, fan.to.lever));
            add_force(D(), force, at.corner_force, rim_slot);
            on_rim = plus(on_rim, force);
            on_end = plus(on_end, scaled<D>(push, cross(fan.from.arm, fan.to.arm)));
            before = scaled<D>(push, fan.from.lever);
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
    const auto fan_sum = transposed<D>(d, sum);
    return plus(force, Vec3<D>{fan_sum.x, fan_sum.y, fan_sum.z});
}

// What stresses do to fans of tetrahedra.

/// The stress of a mean without what has relaxed of it.
/// @param mean  number of the control volume or edge
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

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_FAN_FORCES_INL_HPP
