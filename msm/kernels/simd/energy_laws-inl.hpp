// Energies of coupled springs with their first and second derivatives. Written once for each vector unit: see
// coupled_equilibria.cpp.
#if defined(LIVERMARK_ENERGY_LAWS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_ENERGY_LAWS_INL_HPP
#undef LIVERMARK_ENERGY_LAWS_INL_HPP
#else
#define LIVERMARK_ENERGY_LAWS_INL_HPP
#endif

#include "msm/kernels/simd/neo_hookean_law-inl.hpp"
#include "msm/kernels/simd/fan_forces-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// A measure g of a relative change of volume, see VolumeMeasure: g^2 and the derivatives of g^2 / 2.
template <class D> struct SquaredVolume { hn::Vec<D> square, slope, curvature; };

/// A : B
template <class D> HWY_INLINE hn::Vec<D> contraction(const Symmetric<D> &a, const Symmetric<D> &b) {
    const auto diagonal = hn::MulAdd(a.xx, b.xx, hn::MulAdd(a.yy, b.yy, hn::Mul(a.zz, b.zz)));
    const auto beside = hn::MulAdd(a.xy, b.xy, hn::MulAdd(a.yz, b.yz, hn::Mul(a.zx, b.zx)));
    return hn::Add(diagonal, hn::Add(beside, beside));
}

/// A B A
template <class D> HWY_INLINE Symmetric<D> sandwich(const Symmetric<D> &a, const Symmetric<D> &b) {
    const Vec3<D> x{a.xx, a.xy, a.zx}, y{a.xy, a.yy, a.yz}, z{a.zx, a.yz, a.zz};
    const auto of_x = product<D>(b, x), of_y = product<D>(b, y), of_z = product<D>(b, z);
    return {dot(x, of_x), dot(y, of_y), dot(z, of_z), dot(x, of_y), dot(y, of_z), dot(z, of_x)};
}

/// W_s = mu ((tr E)^2 / 2 + E : E), and g = J - 1. Strains are given as G = 2 E.
template <class D> class HookeLaw {
  public:
    HWY_INLINE HookeLaw(D d, hn::Vec<D> modulus, const Symmetric<D> &twice_strain)
        : modulus_(modulus), half_(hn::Mul(hn::Set(d, 0.5), modulus)), twice_strain_(twice_strain) {}

    HWY_INLINE hn::Vec<D> energy(D d) const {
        const auto &g = twice_strain_;
        const auto trace = hn::Add(g.xx, hn::Add(g.yy, g.zz));
        const auto sum = hn::MulAdd(hn::Mul(hn::Set(d, 0.5), trace), trace, contraction(g, g));
        return hn::Mul(hn::Mul(hn::Set(d, 0.25), modulus_), sum);
    }
    HWY_INLINE Symmetric<D> stress(D /*d*/) const { return of(twice_strain_); }
    /// Along a rate of G.
    HWY_INLINE Symmetric<D> stress_rate(D /*d*/, const Symmetric<D> &rate) const { return of(rate); }

    static HWY_INLINE SquaredVolume<D> volume(D d, hn::Vec<D> change) {
        return {hn::Mul(change, change), change, hn::Set(d, 1.0)};
    }
    static constexpr bool is_finite = true; ///< where a tetrahedron is inside out

  private:
    HWY_INLINE Symmetric<D> of(const Symmetric<D> &g) const {
        return livermark::msm::HWY_NAMESPACE::stress<D>(half_, modulus_, g);
    }

    hn::Vec<D> modulus_, half_;
    Symmetric<D> twice_strain_;
};

/// W_s = mu (tr E - L / 2 + L^2 / 8) with L = ln det C, and g = ln J: see spring_energies/neo_hookean.cpp. Where the
/// determinant is not positive it is taken for 1e-6, so that nothing is infinite but what the caller makes so.
template <class D> class NeoHookeanLaw {
  public:
    HWY_INLINE NeoHookeanLaw(D d, hn::Vec<D> modulus, const Symmetric<D> &twice_strain)
        : modulus_(modulus), twice_strain_(twice_strain), of_(cauchy_green(d, twice_strain, 0.0)),
          log_(hn::Log1p(d, of_.det_change)) {}

    HWY_INLINE hn::Vec<D> energy(D d) const {
        const auto half = hn::Set(d, 0.5), half_log = hn::Mul(half, log_);
        return hn::Mul(modulus_, hn::MulAdd(hn::Mul(half, half_log), half_log, hn::Mul(half, hn::Sub(of_.i1, log_))));
    }
    /// mu (I - C^-1 + L / 2 C^-1), from the invariants of G: see CauchyGreen.
    HWY_INLINE Symmetric<D> stress(D d) const {
        const auto one = hn::Set(d, 1.0), half_log = hn::Mul(hn::Set(d, 0.5), log_);
        const auto scale = hn::Div(modulus_, hn::Add(one, of_.det_change));
        const auto part = hn::Mul(scale, hn::Sub(one, half_log));
        const auto mean = hn::Mul(scale, hn::MulAdd(half_log, hn::Add(one, of_.i1), of_.two_and_three));
        return plus_identity(scaled<D>(part, minus<D>(twice_strain_, of_.adjugate)), mean);
    }
    /// mu ((1 - L / 2) C^-1 R C^-1 + (C^-1 : R) / 2 C^-1) along a rate R of G.
    HWY_INLINE Symmetric<D> stress_rate(D d, const Symmetric<D> &rate) const {
        const auto one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
        const auto inverse = scaled<D>(hn::Div(one, hn::Add(one, of_.det_change)),
                                       plus_identity(minus<D>(of_.adjugate, twice_strain_), hn::Add(one, of_.i1)));
        const auto of_turns = hn::Mul(modulus_, hn::NegMulAdd(half, log_, one));
        const auto of_volume = hn::Mul(modulus_, hn::Mul(half, contraction(inverse, rate)));
        return plus_scaled<D>(scaled<D>(of_turns, sandwich(inverse, rate)), of_volume, inverse);
    }

    static HWY_INLINE SquaredVolume<D> volume(D d, hn::Vec<D> change) {
        const auto one = hn::Set(d, 1.0), bounded = hn::Max(change, hn::Set(d, -1.0 + 1e-6));
        const auto log = hn::Log1p(d, bounded), inverse = hn::Div(one, hn::Add(one, bounded));
        return {hn::Mul(log, log), hn::Mul(log, inverse), hn::Mul(hn::Sub(one, log), hn::Mul(inverse, inverse))};
    }
    static constexpr bool is_finite = false;

  private:
    static HWY_INLINE Symmetric<D> plus_identity(Symmetric<D> a, hn::Vec<D> factor) {
        a.xx = hn::Add(a.xx, factor);
        a.yy = hn::Add(a.yy, factor);
        a.zz = hn::Add(a.zz, factor);
        return a;
    }

    hn::Vec<D> modulus_;
    Symmetric<D> twice_strain_;
    CauchyGreen<D> of_;
    hn::Vec<D> log_;
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_ENERGY_LAWS_INL_HPP
