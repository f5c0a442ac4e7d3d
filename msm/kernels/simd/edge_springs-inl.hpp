// Forces of neo-Hookean springs that are coupled around edges, for slices of stars. Written once for each vector unit:
// see take_steps.cpp.
#if defined(LIVERMARK_EDGE_SPRINGS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_EDGE_SPRINGS_INL_HPP
#undef LIVERMARK_EDGE_SPRINGS_INL_HPP
#else
#define LIVERMARK_EDGE_SPRINGS_INL_HPP
#endif

#include "msm/kernels/simd/neo_hookean_law-inl.hpp"
#include "msm/kernels/simd/stars-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// The forces of the means around 16 edges on the nodes of their stars, and of mu F of springs inside tetrahedra on the
/// ends of these edges (mean_gradients.hpp). What else tetrahedra do is left to their fans. The forces of a star have
/// no resultant, so the start of the axis gets what is left.
/// @tparam Stars  StarsOfF or StarsOfC
template <bool is_damped, template <bool, class> class Stars, class T>
HWY_NOINLINE void edge_spring_forces(StepWorkspace<T> &at, int now, int thread, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    T *kept = at.star_scratch[static_cast<std::size_t>(thread)].data();
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const StarPlaces places(body, slice, lane);
        const std::size_t star = static_cast<std::size_t>(slice) * slice_size + lane;
        const StarFetch<is_damped, T> fetch(at, now, places);
        const Stars<is_damped, T> means(at, fetch, places, hn::Load(d, body.star_inverse_volume.data() + star), kept);
        const auto modulus = hn::Load(d, body.star_modulus.data() + star);
        auto total = neo_hookean_stress(D(), modulus, means.mean(), at.least_stretch, largest);
        if constexpr (is_damped)
            total = plus<D>(total, stress<D>(hn::Mul(hn::Set(d, T(0.5)), modulus), modulus, means.rate()));
        total = without_faded(D(), at, total, star);
        const auto *slot = body.star_slot.data() + places.corner;
        auto sum = no_vector(D());
        const auto on_end = means.forces(total, [&](std::size_t k, const Vec3<D> &force) HWY_ATTR {
            add_force(D(), force, at.corner_force, slot + (2 + k) * slice_size);
            sum = plus(sum, force);
        });
        const auto pull = scaled<D>(hn::Load(d, body.star_stiffness.data() + star), fetch.axis().position);
        const auto end = minus(on_end, pull);
        add_force(D(), end, at.corner_force, slot + slice_size);
        add_force(D(), minus(no_vector(D()), plus(sum, end)), at.corner_force, slot);
    }
    largest.keep(D(), at,
                 static_cast<int>(body.fan_start.size()) - 1 + static_cast<int>(body.volume_row.size()) / slice_size +
                     slice);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_EDGE_SPRINGS_INL_HPP
