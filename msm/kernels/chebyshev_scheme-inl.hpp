// The stages of Runge-Kutta-Chebyshev methods on a slice of nodes. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
#undef LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
#else
#define LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
#endif

#include "msm/kernels/schemes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Where the numbers of one component of some nodes are: of stage j, which is evaluated, and of stage j - 1, in whose
/// place stage j + 1 is written.
template <class T> struct ChebyshevComponent {
    double *position, *velocity;
    T *first_acceleration, *for_position, *for_velocity, *position_before, *velocity_before;
};

/// Stage j stands at v_j = v + h w_j and x_j = x + h c_j v + h^2 g_j. In these the recursion of ChebyshevStage is
///     w_(j+1) = mu w_j + nu w_(j-1) + mu~ a_j + gamma~ a_0,   g_(j+1) = mu g_j + nu g_(j-1) + mu~ w_j,
/// with w_0 = g_0 = 0: sums of accelerations, which need no more digits than the forces have.
struct RungeKuttaChebyshev {
    template <class T>
    static HWY_INLINE ChebyshevComponent<T> component(StepWorkspace<T> &at, int stage, int slice, std::size_t c,
                                                      std::size_t lane) {
        NodeSlice<T> &node = at.nodes[slice];
        auto &stages = at.chebyshev_stages[slice];
        const std::size_t now = stage % 2;
        return {node.position[c].data() + lane,
                node.velocity[c].data() + lane,
                stages.first_acceleration[c].data() + lane,
                stages.for_position[now][c].data() + lane,
                stages.for_velocity[now][c].data() + lane,
                stages.for_position[1 - now][c].data() + lane,
                stages.for_velocity[1 - now][c].data() + lane};
    }

    template <class T>
    static HWY_INLINE DoubleVec velocity_now(const StepScheme & /*scheme*/, int stage, double step,
                                             const ChebyshevComponent<T> &at) {
        const auto velocity = dn::Load(Doubles(), at.velocity);
        return stage == 0 ? velocity : dn::MulAdd(dn::Set(Doubles(), step), as_double(at.for_velocity), velocity);
    }

    template <class T>
    static HWY_INLINE Motion advance(const StepScheme &scheme, int stage, double step, DoubleVec a,
                                     const ChebyshevComponent<T> &at) {
        constexpr Doubles d;
        const auto &next = scheme.chebyshev[stage];
        const auto h = dn::Set(d, step), mu_tilde = dn::Set(d, next.mu_tilde);
        auto for_velocity = dn::Mul(mu_tilde, a);
        auto for_position = dn::Zero(d);
        if (stage == 0) {
            store_as(a, at.first_acceleration);
        } else {
            const auto mu = dn::Set(d, next.mu), w = as_double(at.for_velocity);
            for_velocity = dn::MulAdd(dn::Set(d, next.gamma_tilde), as_double(at.first_acceleration), for_velocity);
            for_velocity = dn::MulAdd(mu, w, for_velocity);
            for_position = dn::MulAdd(mu, as_double(at.for_position), dn::Mul(mu_tilde, w));
            if (stage > 1) {
                const auto nu = dn::Set(d, next.nu);
                for_velocity = dn::MulAdd(nu, as_double(at.velocity_before), for_velocity);
                for_position = dn::MulAdd(nu, as_double(at.position_before), for_position);
            }
        }
        const auto velocity = dn::Load(d, at.velocity);
        const auto along = dn::MulAdd(h, for_position, dn::Mul(dn::Set(d, next.time), velocity));
        const auto moved = dn::MulAdd(h, along, dn::Load(d, at.position));
        const auto later = dn::MulAdd(h, for_velocity, velocity);
        if (stage + 1 == scheme.num_stages()) {
            dn::Store(moved, d, at.position);
            dn::Store(later, d, at.velocity);
        } else {
            store_as(for_position, at.position_before);
            store_as(for_velocity, at.velocity_before);
        }
        return {moved, later};
    }
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_CHEBYSHEV_SCHEME_INL_HPP
