// What integrators make of the forces on a slice of nodes. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_SCHEMES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_SCHEMES_INL_HPP
#undef LIVERMARK_SCHEMES_INL_HPP
#else
#define LIVERMARK_SCHEMES_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/doubles-inl.hpp"
#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// A component of some nodes where the next stage is to be evaluated.
struct Motion {
    DoubleVec position, velocity;
};

/// Where the numbers of one component of some nodes are.
template <class T> struct Component {
    double *position, *velocity;
    T *acceleration, *for_position, *for_velocity; ///< not looked at by methods of one stage
};

template <class T>
HWY_INLINE Component<T> component_without_stages(StepWorkspace<T> &at, int slice, std::size_t c, std::size_t lane) {
    NodeSlice<T> &node = at.nodes[slice];
    return {node.position[c].data() + lane, node.velocity[c].data() + lane, nullptr, nullptr, nullptr};
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

template <class T> HWY_INLINE DoubleVec add_to(T *sum, bool is_first, DoubleVec value) {
    const auto total = is_first ? value : dn::Add(as_double(sum), value);
    store_as(total, sum);
    return total;
}

struct SymplecticEuler {
    template <class T>
    static HWY_INLINE Component<T> component(StepWorkspace<T> &at, int /*stage*/, int slice, std::size_t c,
                                             std::size_t lane) {
        return component_without_stages(at, slice, c, lane);
    }

    template <class T>
    static HWY_INLINE DoubleVec velocity_now(const StepScheme & /*scheme*/, int /*stage*/, double /*step*/,
                                             const Component<T> &at) {
        return dn::Load(Doubles(), at.velocity);
    }

    template <class T>
    static HWY_INLINE Motion advance(const StepScheme & /*scheme*/, int /*stage*/, double step, DoubleVec a,
                                     const Component<T> &at) {
        constexpr Doubles d;
        const auto h = dn::Set(d, step);
        const auto velocity = dn::MulAdd(h, a, dn::Load(d, at.velocity));
        const auto position = dn::MulAdd(h, velocity, dn::Load(d, at.position));
        dn::Store(velocity, d, at.velocity);
        dn::Store(position, d, at.position);
        return {position, velocity};
    }
};

struct VelocityVerlet {
    template <class T>
    static HWY_INLINE Component<T> component(StepWorkspace<T> &at, int /*stage*/, int slice, std::size_t c,
                                             std::size_t lane) {
        return component_with_stages(at, slice, c, lane);
    }

    /// The second evaluation is at a guess, v + h a.
    template <class T>
    static HWY_INLINE DoubleVec velocity_now(const StepScheme & /*scheme*/, int stage, double step,
                                             const Component<T> &at) {
        const auto velocity = dn::Load(Doubles(), at.velocity);
        return stage == 0 ? velocity : dn::MulAdd(dn::Set(Doubles(), step), as_double(at.acceleration), velocity);
    }

    template <class T>
    static HWY_INLINE Motion advance(const StepScheme & /*scheme*/, int stage, double step, DoubleVec a,
                                     const Component<T> &at) {
        constexpr Doubles d;
        const auto h = dn::Set(d, step), half = dn::Set(d, 0.5 * step);
        const auto velocity = dn::Load(d, at.velocity), position = dn::Load(d, at.position);
        if (stage == 0) {
            const auto moved = dn::MulAdd(h, dn::MulAdd(half, a, velocity), position);
            dn::Store(moved, d, at.position);
            store_as(a, at.acceleration);
            return {moved, dn::MulAdd(h, a, velocity)};
        }
        const auto later = dn::MulAdd(half, dn::Add(as_double(at.acceleration), a), velocity);
        dn::Store(later, d, at.velocity);
        return {position, later};
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

    template <class T>
    static HWY_INLINE DoubleVec velocity_now(const StepScheme &scheme, int stage, double step, const Component<T> &at) {
        const auto velocity = dn::Load(Doubles(), at.velocity);
        return stage == 0 ? velocity
                          : dn::MulAdd(dn::Set(Doubles(), step * scheme.next[stage - 1]), as_double(at.acceleration),
                                       velocity);
    }

    template <class T>
    static HWY_INLINE Motion advance(const StepScheme &scheme, int stage, double step, DoubleVec a,
                                     const Component<T> &at) {
        constexpr Doubles d;
        const auto h = dn::Set(d, step);
        const auto position = dn::Load(d, at.position), velocity = dn::Load(d, at.velocity);
        const bool is_first = stage == 0;
        const auto for_velocity = add_to(at.for_velocity, is_first, dn::Mul(dn::Set(d, scheme.weight[stage]), a));
        if (stage + 1 == scheme.num_stages()) {
            const auto sum = is_first ? dn::Zero(d) : as_double(at.for_position);
            const auto moved = dn::MulAdd(h, dn::MulAdd(h, sum, velocity), position);
            const auto later = dn::MulAdd(h, for_velocity, velocity);
            dn::Store(moved, d, at.position);
            dn::Store(later, d, at.velocity);
            return {moved, later};
        }
        const double next = scheme.next[stage];
        add_to(at.for_position, is_first, dn::Mul(dn::Set(d, scheme.weight[stage + 1] * next), a));
        const auto c = dn::Set(d, step * next);
        const auto moved = dn::MulAdd(c, velocity_now(scheme, stage, step, at), position);
        store_as(a, at.acceleration);
        return {moved, dn::MulAdd(c, a, velocity)};
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
    const auto alpha = dn::Set(Doubles(), at.alpha);
    const double step = at.time_step;
    const bool has_loads = !at.loads.empty();
    const auto component = [&](const hn::Vec<D> &of_force, std::size_t c, hn::Vec<D> &position,
                               hn::Vec<D> &velocity) HWY_ATTR {
        DoubleVec total[num_parts<D>()], positions[num_parts<D>()], velocities[num_parts<D>()];
        to_doubles(d, of_force, total);
        for (std::size_t part = 0; part < num_parts<D>(); ++part) {
            const std::size_t l = lane + part * dn::Lanes(Doubles());
            const auto of_node = Scheme::component(at, stage, slice, c, l);
            if (has_loads)
                total[part] = dn::Add(total[part], as_double(at.loads[slice][c].data() + l));
            const auto velocity_now = Scheme::velocity_now(at.scheme, stage, step, of_node);
            const auto a =
                dn::NegMulAdd(alpha, velocity_now, dn::Mul(total[part], as_double(node.free_per_mass[c].data() + l)));
            const auto next = Scheme::advance(at.scheme, stage, step, a, of_node);
            positions[part] = next.position;
            velocities[part] = next.velocity;
        }
        position = from_doubles(d, positions);
        if constexpr (is_damped)
            velocity = from_doubles(d, velocities);
    };
    auto position = force, velocity = force;
    component(force.x, 0, position.x, velocity.x);
    component(force.y, 1, position.y, velocity.y);
    component(force.z, 2, position.z, velocity.z);
    const std::size_t row = (static_cast<std::size_t>(slice) * slice_size + lane) * 4;
    write_rows(d, position, at.rows[1 - now].data() + row);
    if constexpr (is_damped)
        write_rows(d, velocity, at.velocity_rows[1 - now].data() + row);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_SCHEMES_INL_HPP
