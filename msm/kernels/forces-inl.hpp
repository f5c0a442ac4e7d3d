// Forces of springs and volumes for slices of nodes and groups of tetrahedra. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_FORCES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_FORCES_INL_HPP
#undef LIVERMARK_FORCES_INL_HPP
#else
#define LIVERMARK_FORCES_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/fetch-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

template <class D> struct Vec3 { hn::Vec<D> x, y, z; };

template <class D> HWY_INLINE Vec3<D> difference(const Rows<D> &a, const Rows<D> &b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

template <class D> HWY_INLINE hn::Vec<D> dot(const Vec3<D> &a, const Vec3<D> &b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

template <class D> HWY_INLINE Vec3<D> cross(const Vec3<D> &a, const Vec3<D> &b) {
    return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
            hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

/// 1 / sqrt(v)
template <class D, class V> HWY_INLINE V inverse_root(D d, V v) {
    if constexpr (sizeof(hn::TFromD<D>) == 4 && HWY_TARGET != HWY_SCALAR) {
        // One step of Newton's method makes 23 bits of the 11 or 14 that the instruction has.
        const auto guess = hn::ApproximateReciprocalSqrt(v);
        const auto half = hn::Mul(v, hn::Set(d, 0.5F));
        return hn::Mul(guess, hn::NegMulAdd(hn::Mul(half, guess), guess, hn::Set(d, 1.5F)));
    } else {
        return hn::Div(hn::Set(d, hn::TFromD<D>(1)), hn::Sqrt(v));
    }
}

/// Forces on the nodes of a slice.
template <class T> struct alignas(64) SliceForce { T x[slice_size], y[slice_size], z[slice_size]; };

/// k (l - l0 + beta l') n over the springs at each node.
template <bool is_damped, class T>
HWY_INLINE void spring_forces(const StepWorkspace<T> &at, int slice, SliceForce<T> &force) {
    constexpr Lanes<T> d;
    const auto &body = at.body;
    const T *rows = at.rows[at.now].data(), *velocities = at.velocity_rows[at.now].data();
    const auto tiny = hn::Set(d, T(1e-30)); // springs that fill up a slice have no length
    const auto beta = hn::Set(d, static_cast<T>(at.beta));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const std::size_t own = (static_cast<std::size_t>(slice) * slice_size + lane) * 4;
        Rows<Lanes<T>> here, moving;
        hn::LoadInterleaved4(d, rows + own, here.x, here.y, here.z, here.w);
        if constexpr (is_damped)
            hn::LoadInterleaved4(d, velocities + own, moving.x, moving.y, moving.z, moving.w);
        auto x = hn::Zero(d), y = x, z = x;
        const std::size_t end = static_cast<std::size_t>(body.spring_start[slice + 1]) * slice_size;
        for (std::size_t s = static_cast<std::size_t>(body.spring_start[slice]) * slice_size + lane; s < end;
             s += slice_size) {
            const auto *row = body.neighbour.data() + s;
            const auto span = difference(fetch(d, rows, row), here);
            const auto inverse_length = inverse_root(d, hn::Max(dot(span, span), tiny));
            const auto stiffness = hn::Load(d, body.stiffness.data() + s);
            auto tension = hn::NegMulAdd(hn::Load(d, body.pull.data() + s), inverse_length, stiffness);
            if constexpr (is_damped) {
                const auto rate = dot(span, difference(fetch(d, velocities, row), moving));
                tension = hn::MulAdd(hn::Mul(beta, stiffness), hn::Mul(rate, hn::Mul(inverse_length, inverse_length)),
                                     tension);
            }
            x = hn::MulAdd(tension, span.x, x);
            y = hn::MulAdd(tension, span.y, y);
            z = hn::MulAdd(tension, span.z, z);
        }
        hn::Store(x, d, force.x + lane);
        hn::Store(y, d, force.y + lane);
        hn::Store(z, d, force.z + lane);
    }
}

/// Adds what the tetrahedra have given to each node of a slice.
template <class T> HWY_INLINE void add_corner_forces(const StepWorkspace<T> &at, int slice, SliceForce<T> &force) {
    constexpr Lanes<T> d;
    const auto &body = at.body;
    const std::size_t end = static_cast<std::size_t>(body.sum_start[slice + 1]) * slice_size;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        auto x = hn::Load(d, force.x + lane), y = hn::Load(d, force.y + lane), z = hn::Load(d, force.z + lane);
        for (std::size_t s = static_cast<std::size_t>(body.sum_start[slice]) * slice_size + lane; s < end;
             s += slice_size) {
            const auto sum = fetch(d, at.corner_force.data(), body.sum.data() + s);
            x = hn::Add(x, sum.x);
            y = hn::Add(y, sum.y);
            z = hn::Add(z, sum.z);
        }
        hn::Store(x, d, force.x + lane);
        hn::Store(y, d, force.y + lane);
        hn::Store(z, d, force.z + lane);
    }
}

/// The corners of a tetrahedron, as edges from the first, and six times the gradients of its volume at the others.
template <class D> struct Corners {
    Vec3<D> a, b, c;
    Vec3<D> at_a, at_b, at_c;
    hn::Vec<D> pressure; ///< sum over the corners
};

template <class D, class T> HWY_INLINE Corners<D> corners(D d, const T *rows, const std::int32_t *corner) {
    const auto origin = fetch(d, rows, corner), a = fetch(d, rows, corner + slice_size);
    const auto b = fetch(d, rows, corner + 2 * slice_size), c = fetch(d, rows, corner + 3 * slice_size);
    Corners<D> t;
    t.a = difference(a, origin);
    t.b = difference(b, origin);
    t.c = difference(c, origin);
    t.at_a = cross(t.b, t.c);
    t.at_b = cross(t.c, t.a);
    t.at_c = cross(t.a, t.b);
    t.pressure = hn::Add(hn::Add(origin.w, a.w), hn::Add(b.w, c.w));
    return t;
}

/// Six times the rate at which volumes grow.
template <class D, class T>
HWY_INLINE hn::Vec<D> growth(D d, const Corners<D> &t, const T *velocities, const std::int32_t *corner) {
    const auto origin = fetch(d, velocities, corner);
    const auto a = difference(fetch(d, velocities, corner + slice_size), origin);
    const auto b = difference(fetch(d, velocities, corner + 2 * slice_size), origin);
    const auto c = difference(fetch(d, velocities, corner + 3 * slice_size), origin);
    return hn::Add(dot(t.at_a, a), hn::Add(dot(t.at_b, b), dot(t.at_c, c)));
}

/// Volume that each tetrahedron of a group has gained, and beta times how fast it does.
template <bool is_damped, class T> HWY_INLINE void volume_gains(StepWorkspace<T> &at, int group) {
    constexpr Lanes<T> d;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const auto *corner = at.body.corner.data() + static_cast<std::size_t>(group) * 4 * slice_size + lane;
        const std::size_t t = static_cast<std::size_t>(group) * slice_size + lane;
        const auto now = corners(d, at.rows[at.now].data(), corner);
        auto volume = dot(now.a, now.at_a);
        if constexpr (is_damped)
            volume = hn::MulAdd(hn::Set(d, static_cast<T>(at.beta)),
                                growth(d, now, at.velocity_rows[at.now].data(), corner), volume);
        hn::Store(hn::MulSub(volume, sixth, hn::Load(d, at.body.rest_volume.data() + t)), d, at.gain.data() + t);
    }
}

/// A quarter of the pressure around the nodes of 16 rows, into these.
template <class T> HWY_INLINE void pressures(StepWorkspace<T> &at, int volume_slice) {
    constexpr Lanes<T> d;
    const hn::RebindToSigned<Lanes<T>> signed_lanes;
    const hn::Rebind<std::int32_t, Lanes<T>> index_lanes;
    const auto &body = at.body;
    alignas(64) T pressure[slice_size];
    const std::size_t end = static_cast<std::size_t>(body.volume_start[volume_slice + 1]) * slice_size;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        auto sum = hn::Zero(d);
        for (std::size_t m = static_cast<std::size_t>(body.volume_start[volume_slice]) * slice_size + lane; m < end;
             m += slice_size) {
            const auto member = hn::Load(index_lanes, body.member.data() + m);
            if constexpr (sizeof(T) == 4)
                sum = hn::Add(sum, hn::GatherIndex(d, at.gain.data(), member));
            else
                sum = hn::Add(sum, hn::GatherIndex(d, at.gain.data(), hn::PromoteTo(signed_lanes, member)));
        }
        const std::size_t row = static_cast<std::size_t>(volume_slice) * slice_size + lane;
        hn::Store(hn::Mul(hn::Mul(sum, hn::Set(d, T(0.25))), hn::Load(d, body.volume_stiffness.data() + row)), d,
                  pressure + lane);
    }
    T *rows = at.rows[at.now].data() + static_cast<std::size_t>(volume_slice) * slice_size * 4;
    for (int i = 0; i < slice_size; ++i)
        rows[4 * i + 3] = pressure[i];
}

/// What the pressures around the nodes, its own, and the guard against inversion do to the corners of each tetrahedron
/// of a group.
template <bool is_damped, class T> HWY_INLINE void corner_forces(StepWorkspace<T> &at, int group) {
    constexpr Lanes<T> d;
    const auto &body = at.body;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const std::size_t first = static_cast<std::size_t>(group) * 4 * slice_size + lane;
        const std::size_t t = static_cast<std::size_t>(group) * slice_size + lane;
        const auto *corner = body.corner.data() + first;
        const auto now = corners(d, at.rows[at.now].data(), corner);
        auto push = body.volume_stiffness.empty() ? hn::Zero(d) : hn::Neg(now.pressure);
        if (!body.tetrahedron_stiffness.empty()) {
            auto volume = dot(now.a, now.at_a);
            if constexpr (is_damped)
                volume = hn::MulAdd(hn::Set(d, static_cast<T>(at.beta)),
                                    growth(d, now, at.velocity_rows[at.now].data(), corner), volume);
            const auto gain = hn::MulSub(volume, sixth, hn::Load(d, body.rest_volume.data() + t));
            push = hn::NegMulAdd(hn::Load(d, body.tetrahedron_stiffness.data() + t), gain, push);
        }
        if (!body.guard_stiffness.empty()) {
            const auto least = hn::Load(d, body.least_volume.data() + t);
            const auto lack = hn::Max(hn::NegMulAdd(dot(now.a, now.at_a), sixth, least), hn::Zero(d));
            push = hn::MulAdd(hn::Load(d, body.guard_stiffness.data() + t), lack, push);
        }
        push = hn::Mul(push, sixth);
        const Vec3<Lanes<T>> a{hn::Mul(push, now.at_a.x), hn::Mul(push, now.at_a.y), hn::Mul(push, now.at_a.z)};
        const Vec3<Lanes<T>> b{hn::Mul(push, now.at_b.x), hn::Mul(push, now.at_b.y), hn::Mul(push, now.at_b.z)};
        const Vec3<Lanes<T>> c{hn::Mul(push, now.at_c.x), hn::Mul(push, now.at_c.y), hn::Mul(push, now.at_c.z)};
        T *forces = at.corner_force.data();
        const auto *slot = body.force_slot.data() + first;
        scatter_add(d, hn::Neg(hn::Add(a.x, hn::Add(b.x, c.x))), hn::Neg(hn::Add(a.y, hn::Add(b.y, c.y))),
                    hn::Neg(hn::Add(a.z, hn::Add(b.z, c.z))), forces, slot);
        scatter_add(d, a.x, a.y, a.z, forces, slot + slice_size);
        scatter_add(d, b.x, b.y, b.z, forces, slot + 2 * slice_size);
        scatter_add(d, c.x, c.y, c.z, forces, slot + 3 * slice_size);
    }
}

/// The corner forces of all groups of a chunk.
template <bool is_damped, class T> HWY_INLINE void chunk_forces(StepWorkspace<T> &at, int chunk) {
    const auto &body = at.body;
    std::fill(at.corner_force.begin() + 4 * static_cast<std::ptrdiff_t>(body.chunk_start[chunk]),
              at.corner_force.begin() + 4 * static_cast<std::ptrdiff_t>(body.chunk_start[chunk + 1]), T(0));
    const int end = std::min((chunk + 1) * chunk_size, body.num_groups);
    for (int group = chunk * chunk_size; group < end; ++group)
        corner_forces<is_damped>(at, group);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_FORCES_INL_HPP
