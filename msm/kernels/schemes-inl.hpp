// What integrators make of the forces on a slice of nodes. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_SCHEMES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_SCHEMES_INL_HPP
#undef LIVERMARK_SCHEMES_INL_HPP
#else
#define LIVERMARK_SCHEMES_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/forces-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

using Doubles = hn::CappedTag<double, 8>;
using DoubleVec = hn::Vec<Doubles>;

/// Forces of either precision, as doubles.
HWY_INLINE DoubleVec as_double(const double *force) {
    return hn::Load(Doubles(), force);
}
HWY_INLINE DoubleVec as_double(const float *force) {
    return hn::PromoteTo(Doubles(), hn::Load(hn::Rebind<float, Doubles>(), force));
}

HWY_INLINE void store_as(DoubleVec v, double *place) {
    hn::Store(v, Doubles(), place);
}
HWY_INLINE void store_as(DoubleVec v, float *place) {
    const hn::Rebind<float, Doubles> narrow;
    hn::Store(hn::DemoteTo(narrow, v), narrow, place);
}

/// A component of some nodes before the next stage, and where that is to be evaluated.
struct Motion {
    DoubleVec position, velocity;
};

/// One component of some nodes of a slice: where its numbers are, and how its acceleration is found.
struct Component {
    double *position, *velocity;
    const double *free_per_mass, *load;
    double *stage_position, *stage_velocity_sum, *stage_velocity; ///< not looked at by methods of one stage

    DoubleVec acceleration(DoubleVec force, DoubleVec velocity_now, DoubleVec alpha) const HWY_ATTR {
        constexpr Doubles d;
        const auto total = hn::Add(force, hn::Load(d, load));
        return hn::NegMulAdd(alpha, velocity_now, hn::Mul(total, hn::Load(d, free_per_mass)));
    }
};

struct SymplecticEuler {
    static constexpr bool has_stages = false;
    static HWY_INLINE Motion advance(const StepScheme & /*scheme*/, int /*stage*/, double step, double alpha,
                                     DoubleVec force, const Component &at) {
        constexpr Doubles d;
        const auto h = hn::Set(d, step);
        auto velocity = hn::Load(d, at.velocity);
        velocity = hn::MulAdd(h, at.acceleration(force, velocity, hn::Set(d, alpha)), velocity);
        const auto position = hn::MulAdd(h, velocity, hn::Load(d, at.position));
        hn::Store(velocity, d, at.velocity);
        hn::Store(position, d, at.position);
        return {position, velocity};
    }
};

struct VelocityVerlet {
    static constexpr bool has_stages = true;
    static HWY_INLINE Motion advance(const StepScheme & /*scheme*/, int stage, double step, double alpha,
                                     DoubleVec force, const Component &at) {
        constexpr Doubles d;
        const auto h = hn::Set(d, step), half = hn::Set(d, 0.5 * step);
        const auto velocity = hn::Load(d, at.velocity), position = hn::Load(d, at.position);
        if (stage == 0) {
            const auto a = at.acceleration(force, velocity, hn::Set(d, alpha));
            const auto moved = hn::MulAdd(h, hn::MulAdd(half, a, velocity), position);
            const auto guess = hn::MulAdd(h, a, velocity);
            hn::Store(moved, d, at.position);
            hn::Store(a, d, at.stage_velocity_sum);
            hn::Store(guess, d, at.stage_velocity);
            return {moved, guess};
        }
        const auto a = at.acceleration(force, hn::Load(d, at.stage_velocity), hn::Set(d, alpha));
        const auto later = hn::MulAdd(half, hn::Add(hn::Load(d, at.stage_velocity_sum), a), velocity);
        hn::Store(later, d, at.velocity);
        return {position, later};
    }
};

struct RungeKutta {
    static constexpr bool has_stages = true;
    static HWY_INLINE Motion advance(const StepScheme &scheme, int stage, double step, double alpha, DoubleVec force,
                                     const Component &at) {
        constexpr Doubles d;
        const auto weight = hn::Set(d, step * scheme.weight[stage]);
        const auto position = hn::Load(d, at.position), velocity = hn::Load(d, at.velocity);
        const bool is_first = stage == 0;
        const auto now = is_first ? velocity : hn::Load(d, at.stage_velocity);
        const auto a = at.acceleration(force, now, hn::Set(d, alpha));
        const auto position_sum = hn::MulAdd(weight, now, is_first ? position : hn::Load(d, at.stage_position));
        const auto velocity_sum = hn::MulAdd(weight, a, is_first ? velocity : hn::Load(d, at.stage_velocity_sum));
        if (stage + 1 == scheme.num_stages()) {
            hn::Store(position_sum, d, at.position);
            hn::Store(velocity_sum, d, at.velocity);
            return {position_sum, velocity_sum};
        }
        const auto next = hn::Set(d, step * scheme.next[stage]);
        const auto stage_velocity = hn::MulAdd(next, a, velocity);
        hn::Store(position_sum, d, at.stage_position);
        hn::Store(velocity_sum, d, at.stage_velocity_sum);
        hn::Store(stage_velocity, d, at.stage_velocity);
        return {hn::MulAdd(next, now, position), stage_velocity};
    }
};

/// Writes the rows of a slice, and the copies of its nodes.
template <class T>
HWY_INLINE void write_rows(const SlicedBody<T> &body, int slice, const SliceForce<T> &value, Aligned<T> &rows) {
    constexpr Lanes<T> d;
    T *own = rows.data() + static_cast<std::size_t>(slice) * slice_size * 4;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d))
        hn::StoreInterleaved4(hn::Load(d, value.x + lane), hn::Load(d, value.y + lane), hn::Load(d, value.z + lane),
                              hn::Zero(d), d, own + 4 * lane);
    if (body.copied_row.empty())
        return;
    for (int c = body.copy_start[slice]; c < body.copy_start[slice + 1]; ++c)
        std::copy_n(rows.data() + 4 * static_cast<std::size_t>(body.copied_row[c]), 4,
                    rows.data() + 4 * static_cast<std::size_t>(body.first_copy + c));
}

/// From the forces on a slice to the rows of the next stage.
template <class Scheme, bool is_damped, class T>
HWY_INLINE void advance(StepWorkspace<T> &at, int slice, int stage, const SliceForce<T> &force) {
    constexpr Doubles d;
    SliceForce<T> position, velocity;
    NodeSlice &node = at.nodes[slice];
    StageSlice *stages = Scheme::has_stages ? &at.stages[slice] : nullptr;
    const T *const forces[] = {force.x, force.y, force.z};
    T *const positions[] = {position.x, position.y, position.z}, *const velocities[] = {velocity.x, velocity.y,
                                                                                        velocity.z};
    for (int c = 0; c < 3; ++c)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            Component component{.position = node.position[c].data() + lane,
                                .velocity = node.velocity[c].data() + lane,
                                .free_per_mass = node.free_per_mass[c].data() + lane,
                                .load = node.load[c].data() + lane,
                                .stage_position = nullptr,
                                .stage_velocity_sum = nullptr,
                                .stage_velocity = nullptr};
            if constexpr (Scheme::has_stages) {
                component.stage_position = stages->position[c].data() + lane;
                component.stage_velocity_sum = stages->velocity[c].data() + lane;
                component.stage_velocity = stages->stage_velocity[c].data() + lane;
            }
            const auto next =
                Scheme::advance(at.scheme, stage, at.time_step, at.alpha, as_double(forces[c] + lane), component);
            store_as(next.position, positions[c] + lane);
            if constexpr (is_damped)
                store_as(next.velocity, velocities[c] + lane);
        }
    write_rows(at.body, slice, position, at.rows[1 - at.now]);
    if constexpr (is_damped)
        write_rows(at.body, slice, velocity, at.velocity_rows[1 - at.now]);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_SCHEMES_INL_HPP
