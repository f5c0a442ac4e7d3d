// Forces of springs on pairs of slices of nodes. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_SPRING_FORCES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_SPRING_FORCES_INL_HPP
#undef LIVERMARK_SPRING_FORCES_INL_HPP
#else
#define LIVERMARK_SPRING_FORCES_INL_HPP
#endif

#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Positions of nodes and, where stiffness damps, velocities.
template <bool is_damped, class D> struct Ends { Rows<D> position, velocity; };

template <bool is_damped, class T>
HWY_INLINE Ends<is_damped, Lanes<T>> fetch_ends(const StepWorkspace<T> &at, int now, const std::int32_t *index) {
    constexpr Lanes<T> d;
    Ends<is_damped, Lanes<T>> ends;
    ends.position = fetch(d, at.rows[now].data(), index);
    if constexpr (is_damped)
        ends.velocity = fetch(d, at.velocity_rows[now].data(), index);
    return ends;
}

/// The nodes of a slice, those from `lane` on.
template <bool is_damped, class T>
HWY_INLINE Ends<is_damped, Lanes<T>> own_ends(const StepWorkspace<T> &at, int now, int slice, std::size_t lane) {
    constexpr Lanes<T> d;
    const std::size_t own = (static_cast<std::size_t>(slice) * slice_size + lane) * 4;
    Ends<is_damped, Lanes<T>> ends;
    auto &x = ends.position;
    hn::LoadInterleaved4(d, at.rows[now].data() + own, x.x, x.y, x.z, x.w);
    auto &v = ends.velocity;
    if constexpr (is_damped)
        hn::LoadInterleaved4(d, at.velocity_rows[now].data() + own, v.x, v.y, v.z, v.w);
    return ends;
}

/// Factors of a line of springs that add up their forces: these are tension times span.
template <class D> struct Pull {
    hn::Vec<D> tension; ///< k (1 - l0/l + beta l'/l) [N/m]
    Vec3<D> span;
};

/// Tension of springs from here to there.
/// @param spring  k and, 16 further, k l0 / 2
template <bool is_damped, class T>
HWY_INLINE Pull<Lanes<T>> pull(const StepWorkspace<T> &at, const T *spring, const Ends<is_damped, Lanes<T>> &here,
                               const Ends<is_damped, Lanes<T>> &there) {
    constexpr Lanes<T> d;
    const auto three = hn::Set(d, T(3));
    const auto span = difference(there.position, here.position);
    const auto square = squared_length(d, span);
    const auto stiffness = hn::Load(d, spring);
    // The last step of Newton's method, 1 / l = guess (3 - l^2 guess^2) / 2, is part of the tension.
    const auto guess = guess_of_inverse_root(d, square);
    const auto correction = hn::NegMulAdd(hn::Mul(square, guess), guess, three);
    auto tension = hn::NegMulAdd(hn::Mul(hn::Load(d, spring + slice_size), guess), correction, stiffness);
    if constexpr (is_damped) {
        const auto inverse_length = hn::Mul(hn::Mul(guess, hn::Set(d, T(0.5))), correction);
        const auto rate = dot(span, difference(there.velocity, here.velocity));
        const auto beta = hn::Set(d, static_cast<T>(at.beta));
        tension = hn::MulAdd(hn::Mul(beta, stiffness), hn::Mul(rate, hn::Mul(inverse_length, inverse_length)), tension);
    }
    return {tension, span};
}

template <class D> HWY_INLINE void add(const Pull<D> &pull, Vec3<D> &force) {
    force.x = hn::MulAdd(pull.tension, pull.span.x, force.x);
    force.y = hn::MulAdd(pull.tension, pull.span.y, force.y);
    force.z = hn::MulAdd(pull.tension, pull.span.z, force.z);
}

/// Forces on the nodes of a pair of slices.
template <class D> struct PairForces { Vec3<D> first, second; };

/// k (l - l0 + beta l') n over the springs at nodes of a pair of slices, those from `lane` on.
template <bool is_damped, class T>
HWY_INLINE PairForces<Lanes<T>> spring_forces(const StepWorkspace<T> &at, int now, int pair, std::size_t lane) {
    constexpr Lanes<T> d;
    const auto zero = hn::Zero(d);
    PairForces<Lanes<T>> force{{zero, zero, zero}, {zero, zero, zero}};
    const auto &body = at.body;
    if (body.spring_lines.empty())
        return force;
    constexpr std::ptrdiff_t spring_line = 2 * slice_size;
    const SpringLines &lines = body.spring_lines[pair];
    const auto *index = body.neighbour.data() + static_cast<std::ptrdiff_t>(lines.first_neighbour) * slice_size + lane;
    const T *spring = body.spring.data() + lines.first_spring * spring_line + lane;
    const auto first = own_ends<is_damped>(at, now, 2 * pair, lane);
    const auto second = own_ends<is_damped>(at, now, 2 * pair + 1, lane);

    const auto between = pull<is_damped>(at, spring, first, second);
    force.first = scaled<Lanes<T>>(between.tension, between.span);
    force.second = minus(force.second, force.first);
    spring += spring_line;
    for (int line = 0; line < lines.count.shared; ++line, index += slice_size, spring += 2 * spring_line) {
        const auto there = fetch_ends<is_damped>(at, now, index);
        add(pull<is_damped>(at, spring, first, there), force.first);
        add(pull<is_damped>(at, spring + spring_line, second, there), force.second);
    }
    for (int line = 0; line < lines.count.alone[0]; ++line, index += slice_size, spring += spring_line)
        add(pull<is_damped>(at, spring, first, fetch_ends<is_damped>(at, now, index)), force.first);
    for (int line = 0; line < lines.count.alone[1]; ++line, index += slice_size, spring += spring_line)
        add(pull<is_damped>(at, spring, second, fetch_ends<is_damped>(at, now, index)), force.second);
    return force;
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_SPRING_FORCES_INL_HPP
