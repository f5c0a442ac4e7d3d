// What implicit steps begin and end with, as inertia() says. Written once for each vector unit.
#if defined(LIVERMARK_INTERACTIVE_INERTIA_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_INERTIA_INL_HPP
#undef LIVERMARK_INTERACTIVE_INERTIA_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_INERTIA_INL_HPP
#endif

#include "interactive/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// To where nodes go without elasticity; constrained ones go where their velocities take them.
/// @param rows     with displacement, velocity, external and inverse_mass, rows of four
/// @param before   displacement when the step began
/// @param damping  1 + alpha h
template <class Rows> HWY_NOINLINE void predict(Rows &rows, Aligned<float> &before, float step, float damping) {
    const auto h = number(step), inverse_damping = number(1.0F / damping);
    for (std::size_t at = 0; at < rows.displacement.size(); at += hn::Lanes(d)) {
        const auto inverse_mass = hn::Load(d, rows.inverse_mass.data() + at);
        const auto was = hn::Load(d, rows.displacement.data() + at);
        const auto velocity = hn::Load(d, rows.velocity.data() + at);
        const auto pushed = hn::MulAdd(hn::Mul(h, inverse_mass), hn::Load(d, rows.external.data() + at), velocity);
        const auto is_free = hn::Gt(inverse_mass, hn::Zero(d));
        const auto factor = hn::IfThenElse(is_free, hn::Mul(h, inverse_damping), h);
        hn::Store(was, d, before.data() + at);
        hn::Store(hn::MulAdd(factor, pushed, was), d, rows.displacement.data() + at);
    }
}

template <class Rows> HWY_NOINLINE void find_velocities(Rows &rows, const Aligned<float> &before, float per_second) {
    for (std::size_t at = 0; at < rows.displacement.size(); at += hn::Lanes(d))
        hn::Store(hn::Mul(number(per_second),
                          hn::Sub(hn::Load(d, rows.displacement.data() + at), hn::Load(d, before.data() + at))),
                  d, rows.velocity.data() + at);
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_INERTIA_INL_HPP
