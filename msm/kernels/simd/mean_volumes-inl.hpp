// Pressures around nodes from means of changes of volume. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_MEAN_VOLUMES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_MEAN_VOLUMES_INL_HPP
#undef LIVERMARK_MEAN_VOLUMES_INL_HPP
#else
#define LIVERMARK_MEAN_VOLUMES_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/simd/neo_hookean_law-inl.hpp"
#include "msm/kernels/threads/thread_pool.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

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

/// Of control volumes of a slice, those from `lane` on, the means over the corners of tetrahedra around.
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
/// means are taken of g g' of these. All threads call it.
/// @param slices  of control volumes, of this thread
template <bool is_damped, class T>
HWY_NOINLINE void mean_pressures(StepWorkspace<T> &at, int now, const Partition &slices, Barrier &barrier) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    if (body.volume_stiffness.empty())
        return;
    for (int slice = slices.first; slice < slices.last; ++slice) {
        put_changes(at, at.gain, slice, at.change);
        if constexpr (is_damped)
            put_changes(at, at.gain_rate, slice, at.change_rate);
    }
    barrier.wait();
    for (int slice = slices.first; slice < slices.last; ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::size_t first = static_cast<std::size_t>(slice) * slice_size + lane;
            auto push = logarithmic_push(D(), mean_around(D(), body, at.change, slice, lane), at.least_stretch);
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

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_MEAN_VOLUMES_INL_HPP
