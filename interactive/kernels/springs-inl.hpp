// Springs between nodes that have moved. Written once for each vector unit.
#if defined(LIVERMARK_INTERACTIVE_SPRINGS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_SPRINGS_INL_HPP
#undef LIVERMARK_INTERACTIVE_SPRINGS_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_SPRINGS_INL_HPP
#endif

#include "interactive/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

struct StretchedSpring {
    Vec3 now; ///< from one end to the other
    V length, change;

    /// |d| - l = (2 X + u) . u / (|d| + l) keeps the digits of small strains.
    /// @param rest            X, from one end to the other at rest
    /// @param moved           u, the difference of their displacements
    /// @param length_at_rest  l
    HWY_INLINE StretchedSpring(const Vec3 &rest, const Vec3 &moved, V length_at_rest)
        : now(rest + moved), length(hn::Sqrt(dot(now, now))),
          change(hn::Div(dot(rest + now, moved), hn::Add(length, length_at_rest))) {}
};

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_SPRINGS_INL_HPP
