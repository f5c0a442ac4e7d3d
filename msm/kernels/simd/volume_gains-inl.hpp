// Volumes that fans of tetrahedra gain. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_VOLUME_GAINS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_VOLUME_GAINS_INL_HPP
#undef LIVERMARK_VOLUME_GAINS_INL_HPP
#else
#define LIVERMARK_VOLUME_GAINS_INL_HPP
#endif

#include "msm/kernels/simd/neo_hookean_law-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Volume that the tetrahedra at each corner of the fans of a slice have gained, and beta times how fast they do.
/// @tparam has_energy  whether there are neo-Hookean springs with means of F: then rates stay apart, and the push of
/// what
///                     springs inside do is put down
template <bool is_damped, bool has_energy, class T>
HWY_NOINLINE void volume_gains(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto axis = fetch_axis(D(), rows, corner);
        FanRates<is_damped, D> rates;
        rates.begin(d, at, now, corner);
        corner += 2 * slice_size;
        auto from = fetch_rim(D(), axis, rows, corner);
        CornerSum<D> gains{D()};
        [[maybe_unused]] CornerSum<D> growth{D()};
        std::size_t rim = lines.corner + 2 * slice_size;
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim += slice_size) {
            corner += slice_size;
            const auto to = fetch_rim(D(), axis, rows, corner);
            const auto share = hn::Load(d, body.volume_share.data() + t);
            auto volume = hn::Mul(share, volume_between<is_damped>(D(), at, now, from, to, corner, rates));
            if constexpr (is_damped && has_energy) {
                const auto plain = hn::Mul(share, dot(from.lever, to.arm));
                growth.add(D(), hn::Mul(hn::Sub(volume, plain), sixth), at.gain_rate.data() + rim);
                volume = plain;
            }
            if constexpr (has_energy)
                put_push_inside(D(), at, volume, t, largest);
            gains.add(D(), hn::MulSub(volume, sixth, hn::Load(d, body.rest_volume.data() + t)), at.gain.data() + rim);
            from = to;
        }
        gains.finish(D(), at.gain.data() + lines.corner, at.gain.data() + rim);
        if constexpr (is_damped && has_energy)
            growth.finish(D(), at.gain_rate.data() + lines.corner, at.gain_rate.data() + rim);
    }
    if constexpr (has_energy)
        largest.keep(D(), at, slice);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_VOLUME_GAINS_INL_HPP
