// What integrators make of the forces on a slice of nodes. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_SCHEMES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_SCHEMES_INL_HPP
#undef LIVERMARK_SCHEMES_INL_HPP
#else
#define LIVERMARK_SCHEMES_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// A component of some nodes to more digits than a vector has: see FineField. There is no low part in double precision.
template <class T> struct Fine {
    T *high, *low;
};

HWY_INLINE Fine<float> at_lane(FineField<float> &field, std::size_t component, std::size_t lane) {
    return {field.high[component].data() + lane, field.low[component].data() + lane};
}
HWY_INLINE Fine<double> at_lane(FineField<double> &field, std::size_t component, std::size_t lane) {
    return {field.high[component].data() + lane, nullptr};
}

/// value + factor * change, to the digits of a vector.
template <class D> HWY_INLINE hn::Vec<D> moved_by(D d, Fine<float> value, hn::Vec<D> factor, hn::Vec<D> change) {
    return hn::Add(hn::Load(d, value.high), hn::MulAdd(factor, change, hn::Load(d, value.low)));
}
template <class D> HWY_INLINE hn::Vec<D> moved_by(D d, Fine<double> value, hn::Vec<D> factor, hn::Vec<D> change) {
    return hn::MulAdd(factor, change, hn::Load(d, value.high));
}

/// Adds factor * change, and keeps what rounding takes away. @return the sum, to the digits of a vector
template <class D> HWY_INLINE hn::Vec<D> move_by(D d, Fine<float> value, hn::Vec<D> factor, hn::Vec<D> change) {
    const auto high = hn::Load(d, value.high);
    const auto by = hn::MulAdd(factor, change, hn::Load(d, value.low));
    const auto sum = hn::Add(high, by);
    hn::Store(hn::Sub(by, hn::Sub(sum, high)), d, value.low);
    hn::Store(sum, d, value.high);
    return sum;
}
template <class D> HWY_INLINE hn::Vec<D> move_by(D d, Fine<double> value, hn::Vec<D> factor, hn::Vec<D> change) {
    const auto sum = moved_by(d, value, factor, change);
    hn::Store(sum, d, value.high);
    return sum;
}

/// A component of some nodes where the next stage is to be evaluated.
template <class D> struct Motion {
    hn::Vec<D> position, velocity;
};

/// Where the numbers of one component of some nodes are.
template <class T> struct Component {
    Fine<T> position, velocity;
    T *acceleration, *for_position, *for_velocity; ///< not looked at by methods of one stage
};

template <class T>
HWY_INLINE Component<T> component_without_stages(StepWorkspace<T> &at, int slice, std::size_t c, std::size_t lane) {
    NodeSlice<T> &node = at.nodes[slice];
    return {at_lane(node.position, c, lane), at_lane(node.velocity, c, lane), nullptr, nullptr, nullptr};
}

template <class T>
HWY_INLINE Component<T> component_with_stages(StepWorkspace<T> &at, int slice, std::size_t c, std::size_t lane) {
    auto of_node = component_without_stages(at, slice, c, lane);
    auto &stages = at.stages[slice];
    of_node.acceleration = stages.acceleration[c].data() + lane;
    of_node.for_position = stages.for_position[c].data() + lane;
    of_node.for_velocity = stages.for_velocity[c].data() + lane;
    return of_node;
}

/// Adds factor * change, or begins with it.
template <class D, class T>
HWY_INLINE hn::Vec<D> add_to(D d, T *sum, bool is_first, double factor, hn::Vec<D> change) {
    const auto by = hn::Set(d, static_cast<T>(factor));
    const auto total = is_first ? hn::Mul(by, change) : hn::MulAdd(by, change, hn::Load(d, sum));
    hn::Store(total, d, sum);
    return total;
}

struct SymplecticEuler {
    template <class T>
    static HWY_INLINE Component<T> component(StepWorkspace<T> &at, int /*stage*/, int slice, std::size_t c,
                                             std::size_t lane) {
        return component_without_stages(at, slice, c, lane);
    }

    template <class D, class T>
    static HWY_INLINE hn::Vec<D> velocity_now(D d, const StepScheme & /*scheme*/, int /*stage*/, T /*step*/,
                                              const Component<T> &at) {
        return hn::Load(d, at.velocity.high);
    }

    template <class D, class T>
    static HWY_INLINE Motion<D> advance(D d, const StepScheme & /*scheme*/, int /*stage*/, T step, hn::Vec<D> a,
                                        const Component<T> &at) {
        const auto h = hn::Set(d, step);
        const auto velocity = move_by(d, at.velocity, h, a);
        return {move_by(d, at.position, h, velocity), velocity};
    }
};

struct VelocityVerlet {
    template <class T>
    static HWY_INLINE Component<T> component(StepWorkspace<T> &at, int /*stage*/, int slice, std::size_t c,
                                             std::size_t lane) {
        return component_with_stages(at, slice, c, lane);
    }

    /// The second evaluation is at a guess, v + h a.
    template <class D, class T>
    static HWY_INLINE hn::Vec<D> velocity_now(D d, const StepScheme & /*scheme*/, int stage, T step,
                                              const Component<T> &at) {
        return stage == 0 ? hn::Load(d, at.velocity.high)
                          : moved_by(d, at.velocity, hn::Set(d, step), hn::Load(d, at.acceleration));
    }

    template <class D, class T>
    static HWY_INLINE Motion<D> advance(D d, const StepScheme & /*scheme*/, int stage, T step, hn::Vec<D> a,
                                        const Component<T> &at) {
        const auto h = hn::Set(d, step), half = hn::Set(d, step / 2);
        if (stage == 0) {
            hn::Store(a, d, at.acceleration);
            const auto along = hn::MulAdd(half, a, hn::Load(d, at.velocity.high));
            return {move_by(d, at.position, h, along), moved_by(d, at.velocity, h, a)};
        }
        const auto later = move_by(d, at.velocity, half, hn::Add(hn::Load(d, at.acceleration), a));
        return {hn::Load(d, at.position.high), later};
    }
};

/// Stage s is evaluated at v_s = v + h c_(s-1) a_(s-1) and x_s = x + h c_(s-1) v_(s-1). With the weights w_s, which add
/// up to one, the step is v + h sum w_s a_s and x + h v + h^2 sum w_(s+1) c_s a_s: sums of accelerations, which need no
/// more digits than the forces have.
struct RungeKutta {
    template <class T>
    static HWY_INLINE Component<T> component(StepWorkspace<T> &at, int /*stage*/, int slice, std::size_t c,
                                             std::size_t lane) {
        return component_with_stages(at, slice, c, lane);
    }

    template <class D, class T>
    static HWY_INLINE hn::Vec<D> velocity_now(D d, const StepScheme &scheme, int stage, T step,
                                              const Component<T> &at) {
        const auto velocity = hn::Load(d, at.velocity.high);
        if (stage == 0)
            return velocity;
        const auto since = hn::Set(d, step * static_cast<T>(scheme.next[stage - 1]));
        return hn::MulAdd(since, hn::Load(d, at.acceleration), velocity);
    }

    template <class D, class T>
    static HWY_INLINE Motion<D> advance(D d, const StepScheme &scheme, int stage, T step, hn::Vec<D> a,
                                        const Component<T> &at) {
        const auto h = hn::Set(d, step);
        const bool is_first = stage == 0;
        const auto for_velocity = add_to(d, at.for_velocity, is_first, scheme.weight[stage], a);
        if (stage + 1 == scheme.num_stages()) {
            const auto sum = is_first ? hn::Zero(d) : hn::Load(d, at.for_position);
            const auto along = hn::MulAdd(h, sum, hn::Load(d, at.velocity.high));
            return {move_by(d, at.position, h, along), move_by(d, at.velocity, h, for_velocity)};
        }
        const double next = scheme.next[stage];
        const auto velocity = velocity_now(d, scheme, stage, step, at);
        add_to(d, at.for_position, is_first, scheme.weight[stage + 1] * next, a);
        hn::Store(a, d, at.acceleration);
        const auto since = hn::Set(d, step * static_cast<T>(next));
        return {moved_by(d, at.position, since, velocity), moved_by(d, at.velocity, since, a)};
    }
};

/// Puts vectors at nodes of a slice into their rows.
template <class D, class T> HWY_INLINE void write_rows(D d, const Vec3<D> &value, T *rows) {
    hn::StoreInterleaved4(value.x, value.y, value.z, hn::Zero(d), d, rows);
}

/// Where a node of a slice has copies of its row, these follow it.
template <bool is_damped, class T> HWY_INLINE void write_copies(StepWorkspace<T> &at, int next, int slice) {
    const auto &body = at.body;
    for (int c = body.copy_start[slice]; c < body.copy_start[slice + 1]; ++c) {
        const std::size_t from = 4 * static_cast<std::size_t>(body.copied_row[c]);
        const std::size_t to = 4 * static_cast<std::size_t>(body.first_copy + c);
        std::copy_n(at.rows[next].data() + from, 4, at.rows[next].data() + to);
        if constexpr (is_damped)
            std::copy_n(at.velocity_rows[next].data() + from, 4, at.velocity_rows[next].data() + to);
    }
}

/// From the forces on nodes of a slice, those from `lane` on, to their rows of the next stage.
template <class Scheme, bool is_damped, class D, class T>
HWY_INLINE void advance(D d, StepWorkspace<T> &at, int now, int slice, std::size_t lane, int stage,
                        const Vec3<D> &force) {
    const NodeSlice<T> &node = at.nodes[slice];
    const auto alpha = hn::Set(d, static_cast<T>(at.alpha));
    const T step = static_cast<T>(at.time_step);
    const bool has_loads = !at.loads.empty();
    const auto component = [&](hn::Vec<D> total, std::size_t c) HWY_ATTR {
        const auto of_node = Scheme::component(at, stage, slice, c, lane);
        if (has_loads)
            total = hn::Add(total, hn::Load(d, at.loads[slice][c].data() + lane));
        const auto per_mass = hn::Mul(total, hn::Load(d, node.free_per_mass[c].data() + lane));
        const auto a = hn::NegMulAdd(alpha, Scheme::velocity_now(d, at.scheme, stage, step, of_node), per_mass);
        return Scheme::advance(d, at.scheme, stage, step, a, of_node);
    };
    const Motion<D> x = component(force.x, 0), y = component(force.y, 1), z = component(force.z, 2);
    const std::size_t row = (static_cast<std::size_t>(slice) * slice_size + lane) * 4;
    write_rows(d, Vec3<D>{x.position, y.position, z.position}, at.rows[1 - now].data() + row);
    if constexpr (is_damped)
        write_rows(d, Vec3<D>{x.velocity, y.velocity, z.velocity}, at.velocity_rows[1 - now].data() + row);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_SCHEMES_INL_HPP
