// Forces of springs on slices of nodes. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_SPRING_FORCES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_SPRING_FORCES_INL_HPP
#undef LIVERMARK_SPRING_FORCES_INL_HPP
#else
#define LIVERMARK_SPRING_FORCES_INL_HPP
#endif

#include "msm/kernels/roots-inl.hpp"
#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// k (l - l0 + beta l') n over the springs at nodes of a slice, those from `lane` on.
template <bool is_damped, class T>
HWY_INLINE Vec3<Lanes<T>> spring_forces(const StepWorkspace<T> &at, int now, int slice, std::size_t lane) {
    constexpr Lanes<T> d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data(), *velocities = at.velocity_rows[now].data();
    const auto three = hn::Set(d, T(3)), half = hn::Set(d, T(0.5));
    const auto beta = hn::Set(d, static_cast<T>(at.beta));
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
        const auto square = dot(span, span);
        const auto stiffness = hn::Load(d, body.stiffness.data() + s);
        // The last step of Newton's method, 1 / l = guess (3 - l^2 guess^2) / 2, is part of the tension.
        const auto guess = guess_of_inverse_root(Lanes<T>(), square);
        const auto correction = hn::NegMulAdd(hn::Mul(square, guess), guess, three);
        auto tension = hn::NegMulAdd(hn::Mul(hn::Load(d, body.half_pull.data() + s), guess), correction, stiffness);
        if constexpr (is_damped) {
            const auto inverse_length = hn::Mul(hn::Mul(guess, half), correction);
            const auto rate = dot(span, difference(fetch(d, velocities, row), moving));
            tension =
                hn::MulAdd(hn::Mul(beta, stiffness), hn::Mul(rate, hn::Mul(inverse_length, inverse_length)), tension);
        }
        x = hn::MulAdd(tension, span.x, x);
        y = hn::MulAdd(tension, span.y, y);
        z = hn::MulAdd(tension, span.z, z);
    }
    return {x, y, z};
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_SPRING_FORCES_INL_HPP
