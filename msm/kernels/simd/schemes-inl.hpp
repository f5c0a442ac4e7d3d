// Steps of integrators under the forces on a slice of nodes. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_SCHEMES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_SCHEMES_INL_HPP
#undef LIVERMARK_SCHEMES_INL_HPP
#else
#define LIVERMARK_SCHEMES_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// A component of some nodes to more digits than a vector has: see FineField. There is no low part in double precision.
template <class T> struct Fine { T *high, *low; };

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

/// The same, but no further than to a limit on either side. What is no number stays so.
template <class D>
HWY_INLINE hn::Vec<D> move_within(D d, Fine<hn::TFromD<D>> value, hn::Vec<D> factor, hn::Vec<D> change,
                                  hn::Vec<D> limit) {
    const auto sum = move_by(d, value, factor, change);
    const auto is_beyond = hn::Gt(hn::Abs(sum), limit);
    const auto within = hn::IfThenElse(is_beyond, hn::CopySignToAbs(limit, sum), sum);
    hn::Store(within, d, value.high);
    if constexpr (sizeof(hn::TFromD<D>) == 4)
        hn::Store(hn::IfThenZeroElse(is_beyond, hn::Load(d, value.low)), d, value.low);
    return within;
}

/// A component of some nodes where the next stage is to be evaluated.
template <class D> struct Motion { hn::Vec<D> position, velocity; };

/// Places of the numbers of one component of some nodes.
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
    auto node_component = component_without_stages(at, slice, c, lane);
    auto &stages = at.stages[slice];
    node_component.acceleration = stages.acceleration[c].data() + lane;
    node_component.for_position = stages.for_position[c].data() + lane;
    node_component.for_velocity = stages.for_velocity[c].data() + lane;
    return node_component;
}

/// Adds factor * change, or begins with it.
template <class D, class T> HWY_INLINE hn::Vec<D> add_to(D d, T *sum, bool is_first, T factor, hn::Vec<D> change) {
    const auto by = hn::Set(d, factor);
    const auto total = is_first ? hn::Mul(by, change) : hn::MulAdd(by, change, hn::Load(d, sum));
    hn::Store(total, d, sum);
    return total;
}

// What a method does at a stage, with the numbers that it needs there: they are made once for all slices.

template <class T> class SymplecticEuler {
  public:
    SymplecticEuler(const StepScheme &scheme, int /*stage*/, double step)
        : step_(static_cast<T>(step)), largest_speed_(static_cast<T>(scheme.largest_speed)) {}

    HWY_INLINE Component<T> component(StepWorkspace<T> &at, int slice, std::size_t c, std::size_t lane) const {
        return component_without_stages(at, slice, c, lane);
    }

    template <class D> HWY_INLINE hn::Vec<D> velocity_now(D d, const Component<T> &at) const {
        return hn::Load(d, at.velocity.high);
    }

    template <class D> HWY_INLINE Motion<D> advance(D d, hn::Vec<D> a, const Component<T> &at) const {
        const auto h = hn::Set(d, step_);
        const auto velocity = move_within(d, at.velocity, h, a, hn::Set(d, largest_speed_));
        return {move_by(d, at.position, h, velocity), velocity};
    }

  private:
    T step_, largest_speed_;
};

template <class T> class VelocityVerlet {
  public:
    VelocityVerlet(const StepScheme & /*scheme*/, int stage, double step)
        : step_(static_cast<T>(step)), is_first_(stage == 0) {}

    HWY_INLINE Component<T> component(StepWorkspace<T> &at, int slice, std::size_t c, std::size_t lane) const {
        return component_with_stages(at, slice, c, lane);
    }

    /// The second evaluation is at a guess, v + h a.
    template <class D> HWY_INLINE hn::Vec<D> velocity_now(D d, const Component<T> &at) const {
        return is_first_ ? hn::Load(d, at.velocity.high)
                         : moved_by(d, at.velocity, hn::Set(d, step_), hn::Load(d, at.acceleration));
    }

    template <class D> HWY_INLINE Motion<D> advance(D d, hn::Vec<D> a, const Component<T> &at) const {
        const auto h = hn::Set(d, step_), half = hn::Set(d, step_ / 2);
        if (is_first_) {
            hn::Store(a, d, at.acceleration);
            const auto along = hn::MulAdd(half, a, hn::Load(d, at.velocity.high));
            return {move_by(d, at.position, h, along), moved_by(d, at.velocity, h, a)};
        }
        const auto later = move_by(d, at.velocity, half, hn::Add(hn::Load(d, at.acceleration), a));
        return {hn::Load(d, at.position.high), later};
    }

  private:
    T step_;
    bool is_first_;
};

/// Stage s is evaluated at v_s = v + h c_(s-1) a_(s-1) and x_s = x + h c_(s-1) v_(s-1). With the weights w_s, which add
/// up to one, the step is v + h sum w_s a_s and x + h v + h^2 sum w_(s+1) c_s a_s: sums of accelerations, which need no
/// more digits than the forces have.
template <class T> class RungeKutta {
  public:
    RungeKutta(const StepScheme &scheme, int stage, double step)
        : step_(static_cast<T>(step)), weight_(static_cast<T>(scheme.weight[stage])), is_first_(stage == 0),
          is_last_(stage + 1 == scheme.num_stages()) {
        if (!is_first_)
            before_ = static_cast<T>(step * scheme.next[stage - 1]);
        if (!is_last_) {
            next_ = static_cast<T>(step * scheme.next[stage]);
            weight_in_position_ = static_cast<T>(scheme.weight[stage + 1] * scheme.next[stage]);
        }
    }

    HWY_INLINE Component<T> component(StepWorkspace<T> &at, int slice, std::size_t c, std::size_t lane) const {
        return component_with_stages(at, slice, c, lane);
    }

    template <class D> HWY_INLINE hn::Vec<D> velocity_now(D d, const Component<T> &at) const {
        const auto velocity = hn::Load(d, at.velocity.high);
        return is_first_ ? velocity : hn::MulAdd(hn::Set(d, before_), hn::Load(d, at.acceleration), velocity);
    }

    template <class D> HWY_INLINE Motion<D> advance(D d, hn::Vec<D> a, const Component<T> &at) const {
        const auto velocity = velocity_now(d, at);
        const auto for_velocity = add_to(d, at.for_velocity, is_first_, weight_, a);
        if (is_last_) {
            const auto h = hn::Set(d, step_);
            const auto sum = is_first_ ? hn::Zero(d) : hn::Load(d, at.for_position);
            const auto along = hn::MulAdd(h, sum, hn::Load(d, at.velocity.high));
            return {move_by(d, at.position, h, along), move_by(d, at.velocity, h, for_velocity)};
        }
        add_to(d, at.for_position, is_first_, weight_in_position_, a);
        hn::Store(a, d, at.acceleration);
        const auto next = hn::Set(d, next_);
        return {moved_by(d, at.position, next, velocity), moved_by(d, at.velocity, next, a)};
    }

  private:
    T step_, weight_, before_ = T(0), next_ = T(0), weight_in_position_ = T(0);
    bool is_first_, is_last_;
};

/// Copies of the rows of a slice follow their nodes.
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

/// From the forces on nodes of a slice, those from `lane` on, to their rows of the next stage. Everything is looked up
/// before anything is stored, because the compiler cannot know that vectors are not stored over what it looks up.
template <bool is_damped, class Scheme, class D, class T>
HWY_INLINE void advance(D d, const Scheme &scheme, StepWorkspace<T> &at, int now, int slice, std::size_t lane,
                        Vec3<D> force) {
    const auto x_component = scheme.component(at, slice, 0, lane), y_component = scheme.component(at, slice, 1, lane),
               z_component = scheme.component(at, slice, 2, lane);
    const std::size_t row = (static_cast<std::size_t>(slice) * slice_size + lane) * 4;
    T *to = at.rows[1 - now].data() + row;
    [[maybe_unused]] T *velocity_to = nullptr;
    if constexpr (is_damped)
        velocity_to = at.velocity_rows[1 - now].data() + row;
    const auto load = [&](const SliceField<T> &field, std::size_t c)
                          HWY_ATTR { return hn::Load(d, field[c].data() + lane); };
    if (!at.loads.empty()) {
        const auto &loads = at.loads[slice];
        force = plus(force, Vec3<D>{load(loads, 0), load(loads, 1), load(loads, 2)});
    }
    const auto &per_mass = at.nodes[slice].free_per_mass;
    const auto alpha = hn::Set(d, static_cast<T>(at.alpha));
    const auto acceleration = [&](const hn::Vec<D> &total, std::size_t c, const auto &node_component) HWY_ATTR {
        return hn::NegMulAdd(alpha, scheme.velocity_now(d, node_component), hn::Mul(total, load(per_mass, c)));
    };
    const Vec3<D> a{acceleration(force.x, 0, x_component), acceleration(force.y, 1, y_component),
                    acceleration(force.z, 2, z_component)};
    const Motion<D> x = scheme.advance(d, a.x, x_component), y = scheme.advance(d, a.y, y_component),
                    z = scheme.advance(d, a.z, z_component);
    hn::StoreInterleaved4(x.position, y.position, z.position, hn::Zero(d), d, to);
    if constexpr (is_damped)
        hn::StoreInterleaved4(x.velocity, y.velocity, z.velocity, hn::Zero(d), d, velocity_to);
}

// The stages of Runge-Kutta-Chebyshev methods on a slice of nodes.

/// Places of the numbers of one component of some nodes: of stage j, which is evaluated, and of stage j - 1, in whose
/// place stage j + 1 is written.
template <class T> struct ChebyshevComponent {
    Fine<T> position, velocity;
    T *first_acceleration, *for_position, *for_velocity, *position_before, *velocity_before;
};

/// Stage j stands at v_j = v + h w_j and x_j = x + h c_j v + h^2 g_j. In these the recursion of ChebyshevStage is
///     w_(j+1) = mu w_j + nu w_(j-1) + mu~ a_j + gamma~ a_0,   g_(j+1) = mu g_j + nu g_(j-1) + mu~ w_j,
/// with w_0 = g_0 = 0: sums of accelerations, which need no more digits than the forces have.
template <class T> class RungeKuttaChebyshev {
  public:
    RungeKuttaChebyshev(const StepScheme &scheme, int stage, double step)
        : step_(static_cast<T>(step)), mu_(static_cast<T>(scheme.chebyshev[stage].mu)),
          nu_(static_cast<T>(scheme.chebyshev[stage].nu)), mu_tilde_(static_cast<T>(scheme.chebyshev[stage].mu_tilde)),
          gamma_tilde_(static_cast<T>(scheme.chebyshev[stage].gamma_tilde)),
          time_(static_cast<T>(scheme.chebyshev[stage].time)), stage_(stage),
          is_last_(stage + 1 == scheme.num_stages()) {}

    HWY_INLINE ChebyshevComponent<T> component(StepWorkspace<T> &at, int slice, std::size_t c, std::size_t lane) const {
        NodeSlice<T> &node = at.nodes[slice];
        auto &stages = at.chebyshev_stages[slice];
        const std::size_t now = stage_ % 2;
        return {at_lane(node.position, c, lane),
                at_lane(node.velocity, c, lane),
                stages.first_acceleration[c].data() + lane,
                stages.for_position[now][c].data() + lane,
                stages.for_velocity[now][c].data() + lane,
                stages.for_position[1 - now][c].data() + lane,
                stages.for_velocity[1 - now][c].data() + lane};
    }

    template <class D> HWY_INLINE hn::Vec<D> velocity_now(D d, const ChebyshevComponent<T> &at) const {
        const auto velocity = hn::Load(d, at.velocity.high);
        return stage_ == 0 ? velocity : hn::MulAdd(hn::Set(d, step_), hn::Load(d, at.for_velocity), velocity);
    }

    template <class D> HWY_INLINE Motion<D> advance(D d, hn::Vec<D> a, const ChebyshevComponent<T> &at) const {
        const auto h = hn::Set(d, step_), mu_tilde = hn::Set(d, mu_tilde_);
        auto for_velocity = hn::Mul(mu_tilde, a);
        auto for_position = hn::Zero(d);
        if (stage_ == 0) {
            hn::Store(a, d, at.first_acceleration);
        } else {
            const auto mu = hn::Set(d, mu_), w = hn::Load(d, at.for_velocity);
            for_velocity = hn::MulAdd(hn::Set(d, gamma_tilde_), hn::Load(d, at.first_acceleration), for_velocity);
            for_velocity = hn::MulAdd(mu, w, for_velocity);
            for_position = hn::MulAdd(mu, hn::Load(d, at.for_position), hn::Mul(mu_tilde, w));
            if (stage_ > 1) {
                const auto nu = hn::Set(d, nu_);
                for_velocity = hn::MulAdd(nu, hn::Load(d, at.velocity_before), for_velocity);
                for_position = hn::MulAdd(nu, hn::Load(d, at.position_before), for_position);
            }
        }
        const auto along = hn::MulAdd(h, for_position, hn::Mul(hn::Set(d, time_), hn::Load(d, at.velocity.high)));
        if (is_last_)
            return {move_by(d, at.position, h, along), move_by(d, at.velocity, h, for_velocity)};
        hn::Store(for_position, d, at.position_before);
        hn::Store(for_velocity, d, at.velocity_before);
        return {moved_by(d, at.position, h, along), moved_by(d, at.velocity, h, for_velocity)};
    }

  private:
    T step_, mu_, nu_, mu_tilde_, gamma_tilde_, time_;
    int stage_;
    bool is_last_;
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_SCHEMES_INL_HPP
