// What stresses do to fans of tetrahedra. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_STRESSED_FANS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_STRESSED_FANS_INL_HPP
#undef LIVERMARK_STRESSED_FANS_INL_HPP
#else
#define LIVERMARK_STRESSED_FANS_INL_HPP
#endif

#include "msm/kernels/simd/fan_forces-inl.hpp"
#include "msm/kernels/simd/symmetric-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

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

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_STRESSED_FANS_INL_HPP
