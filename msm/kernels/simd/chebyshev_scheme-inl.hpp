// The stages of Runge-Kutta-Chebyshev methods on a slice of nodes. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
#undef LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
#else
#define LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
#endif

#include "msm/kernels/simd/schemes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Where the numbers of one component of some nodes are: of stage j, which is evaluated, and of stage j - 1, in whose
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

#endif // LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
