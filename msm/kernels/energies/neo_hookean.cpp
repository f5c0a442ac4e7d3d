// The neo-Hookean energy of means of C or F, for springs around nodes or edges.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/energies/neo_hookean.cpp"
#include <hwy/foreach_target.h> // has to come before highway.h

#include "core/support/vector_dispatch.hpp"
#include "msm/kernels/energy_kernels.hpp"
#include "msm/kernels/simd/coupled_equilibria-inl.hpp"
#include "msm/kernels/simd/coupled_steps-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// W_s = mu (tr E - L / 2 + L^2 / 8) with L = ln det C, and g = ln J: see spring_energies/neo_hookean.cpp. Where the
/// determinant is not positive it is taken for 1e-6, so that nothing is infinite but what the caller makes so.
template <class D> class NeoHookean {
    using T = hn::TFromD<D>;

  public:
    HWY_INLINE NeoHookean(D d, hn::Vec<D> modulus, const Symmetric<D> &twice_strain, double least_stretch = 0.0)
        : modulus_(modulus), twice_strain_(twice_strain), of_(cauchy_green(d, twice_strain, least_stretch)),
          log_(hn::Log1p(d, of_.det_change)) {}

    HWY_INLINE const CauchyGreen<D> &strain() const { return of_; }

    HWY_INLINE hn::Vec<D> energy(D d) const {
        const auto half = hn::Set(d, 0.5), half_log = hn::Mul(half, log_);
        return hn::Mul(modulus_, hn::MulAdd(hn::Mul(half, half_log), half_log, hn::Mul(half, hn::Sub(of_.i1, log_))));
    }
    /// S = mu (I - C^-1 + L / 2 C^-1), from the invariants of G: see CauchyGreen.
    HWY_INLINE Symmetric<D> stress(D d) const {
        const auto one = hn::Set(d, T(1)), half_log = hn::Mul(hn::Set(d, T(0.5)), log_);
        const auto scale = hn::Div(modulus_, hn::Add(one, of_.det_change));
        const auto part = hn::Mul(scale, hn::Sub(one, half_log));
        const auto mean = hn::Mul(scale, hn::MulAdd(half_log, hn::Add(one, of_.i1), of_.two_and_three));
        const auto along = [&](const hn::Vec<D> &g, const hn::Vec<D> &a)
                               HWY_ATTR { return hn::Mul(part, hn::Sub(g, a)); };
        const auto diagonal = [&](const hn::Vec<D> &g, const hn::Vec<D> &a)
                                  HWY_ATTR { return hn::MulAdd(part, hn::Sub(g, a), mean); };
        const auto &[xx, yy, zz, xy, yz, zx] = twice_strain_;
        const auto &adjugate = of_.adjugate;
        return {diagonal(xx, adjugate.xx), diagonal(yy, adjugate.yy), diagonal(zz, adjugate.zz),
                along(xy, adjugate.xy),    along(yz, adjugate.yz),    along(zx, adjugate.zx)};
    }
    HWY_INLINE Symmetric<D> isochoric_stress(D d) const {
        return livermark::msm::HWY_NAMESPACE::isochoric_stress(d, modulus_, twice_strain_, of_);
    }
    /// mu ((1 - L / 2) C^-1 R C^-1 + (C^-1 : R) / 2 C^-1) along a rate R of G.
    HWY_INLINE Symmetric<D> stress_rate(D d, const Symmetric<D> &rate) const {
        const auto one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
        const auto inverse = scaled<D>(hn::Div(one, hn::Add(one, of_.det_change)),
                                       plus_identity(minus<D>(of_.adjugate, twice_strain_), hn::Add(one, of_.i1)));
        const auto turning = hn::Mul(modulus_, hn::NegMulAdd(half, log_, one));
        const auto swelling = hn::Mul(modulus_, hn::Mul(half, contraction(inverse, rate)));
        return plus_scaled<D>(scaled<D>(turning, sandwich(inverse, rate)), swelling, inverse);
    }

    static HWY_INLINE SquaredVolume<D> volume(D d, hn::Vec<D> change) {
        const auto one = hn::Set(d, 1.0), bounded = hn::Max(change, hn::Set(d, -1.0 + 1e-6));
        const auto log = hn::Log1p(d, bounded), inverse = hn::Div(one, hn::Add(one, bounded));
        return {hn::Mul(log, log), hn::Mul(log, inverse), hn::Mul(hn::Sub(one, log), hn::Mul(inverse, inverse))};
    }
    /// g g'
    static HWY_INLINE hn::Vec<D> volume_push(D d, hn::Vec<D> change) {
        return hn::Div(hn::Log1p(d, change), hn::Add(hn::Set(d, T(1)), change));
    }
    /// (1 - ln J) / J, with the sign of J: S = mu (I - C^-1 + ln J C^-1) is mu F + mu (ln J - 1) / J cof F.
    static HWY_INLINE hn::Vec<D> push_inside(D d, hn::Vec<D> j, hn::Vec<D> square) {
        const auto log = hn::Mul(hn::Set(d, T(0.5)), hn::Log(d, square));
        return hn::Mul(hn::Sub(hn::Set(d, T(1)), log), hn::Div(j, square));
    }
    static constexpr bool is_finite = false;

  private:
    hn::Vec<D> modulus_;
    Symmetric<D> twice_strain_;
    CauchyGreen<D> of_;
    hn::Vec<D> log_;
};

EnergyFunctions neo_hookean_functions() {
    return functions_of_energy<NeoHookean>();
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::msm {

LIVERMARK_DISPATCH(EnergyFunctions neo_hookean_kernels, neo_hookean_functions, (), ())

} // namespace livermark::msm
#endif
