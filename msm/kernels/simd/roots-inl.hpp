// Inverse square roots. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_ROOTS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_ROOTS_INL_HPP
#undef LIVERMARK_ROOTS_INL_HPP
#else
#define LIVERMARK_ROOTS_INL_HPP
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// One step of Newton's method for 1 / sqrt(v), which doubles the digits of a guess.
template <class D, class V> HWY_INLINE V refined(D d, V v, V guess) {
    using T = hn::TFromD<D>;
    const auto half = hn::Mul(v, hn::Set(d, T(0.5)));
    return hn::Mul(guess, hn::NegMulAdd(hn::Mul(half, guess), guess, hn::Set(d, T(1.5))));
}

/// 1 / sqrt(v) to half the digits at least: what one more step makes precise. The instructions that take a root and
/// divide need several times as long. Where there is no quick guess, or the numbers are to be those of another machine,
/// it is exact.
template <class D, class V> HWY_INLINE V guess_of_inverse_root(D d, V v) {
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128 || defined(LIVERMARK_EXACT_ROOTS)
    return hn::Div(hn::Set(d, hn::TFromD<D>(1)), hn::Sqrt(v));
#else
    if constexpr (sizeof(hn::TFromD<D>) == 4) {
        return hn::ApproximateReciprocalSqrt(v);
    } else {
        const hn::Rebind<float, D> narrow;
        const auto in_single = hn::DemoteTo(narrow, v);
        const auto guess = refined(narrow, in_single, hn::ApproximateReciprocalSqrt(in_single));
        return refined(d, v, hn::PromoteTo(d, guess));
    }
#endif
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_ROOTS_INL_HPP
