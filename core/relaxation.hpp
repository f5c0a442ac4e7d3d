#pragma once

#include <string>
#include <vector>

namespace livermark::core {

/// Damping forces D v with D = alpha M + beta K (Rayleigh).
struct RayleighDamping {
    double alpha = 0.0; ///< of the mass [1/s], >= 0
    double beta = 0.0;  ///< of the stiffness [s], >= 0

    /// Damping ratio of a mode, zeta = (alpha / omega + beta omega) / 2.
    /// @param omega  undamped angular frequency of the mode [rad/s], > 0
    double ratio(double omega) const { return 0.5 * (alpha / omega + beta * omega); }
};

/// The damping that has one ratio at two frequencies, less between them and more outside:
/// alpha = 2 zeta omega_1 omega_2 / (omega_1 + omega_2), beta = 2 zeta / (omega_1 + omega_2).
/// @param ratio             zeta >= 0
/// @param omega_1, omega_2  [rad/s], > 0; may be equal
inline RayleighDamping rayleigh_damping(double ratio, double omega_1, double omega_2) {
    return {.alpha = 2.0 * ratio * omega_1 * omega_2 / (omega_1 + omega_2), .beta = 2.0 * ratio / (omega_1 + omega_2)};
}

/// Relaxation of tissue: quasi-linear viscoelasticity with a Prony series (Fung, Biomechanics, 1993, ch. 7; Simo and
/// Hughes, Computational Inelasticity, 1998, ch. 10). The deviatoric stress of the elastic law fades as
///   G(t) / G(0) = 1 - sum_k g_k (1 - exp(-t / tau_k)),
/// so the elastic law is what an instant press meets. The volumetric part stays elastic.
struct PronySeries {
    std::string name;           ///< file stem
    std::vector<double> moduli; ///< (B) g_k, each at least 0, their sum below 1
    std::vector<double> times;  ///< (B) tau_k [s], > 0

    bool is_elastic() const { return moduli.empty(); }
    /// G after all time over G at once.
    double remaining() const {
        double rest = 1.0;
        for (const double modulus : moduli) {
            rest -= modulus;
        }
        return rest;
    }
    bool operator==(const PronySeries &) const = default;
};

/// Step in time of one Maxwell branch, in which the elastic stress s changes linearly. Its stress h obeys
///   dh/dt + h / tau = g ds/dt,   h(0) = g s(0),
/// which this integrates exactly, for every length of the step (Taylor, Pister, Goudreau 1970, Int. J. Numer. Methods
/// Eng. 2(1); Simo and Hughes, Computational Inelasticity, 1998, section 10.3):
///   h(n+1) = fade h(n) + gain (s(n+1) - s(n)),   stress(n+1) = remaining() s(n+1) + sum over branches of h(n+1).
/// s is any stress or force that the instant elastic law gives: deviatoric stresses, forces of springs.
struct BranchStep {
    double modulus = 0.0; ///< g of the branch
    double fade = 1.0;    ///< exp(-x) with x = step / tau
    double gain = 0.0;    ///< g (1 - exp(-x)) / x
    /// Coefficients of the dissipated energy, dimensionless: see dissipated().
    double loss_of_stress = 0.0, loss_of_both = 0.0, loss_of_change = 0.0;

    /// Energy that the dashpot of a linear branch turns into heat in the step, the integral of h . h / (g tau) over
    /// it, times the modulus c that relates the elastic stress to the strain, s = c e (2 G, or the stiffness of a
    /// spring): divide by c. Never negative.
    /// @param stress      h(n) . h(n)
    /// @param both        h(n) . (s(n+1) - s(n))
    /// @param change      (s(n+1) - s(n)) . (s(n+1) - s(n))
    double dissipated(double stress, double both, double change) const {
        return loss_of_stress * stress + loss_of_both * both + loss_of_change * change;
    }
    /// Energy that the spring of a linear branch stores, times the same c.
    /// @param stress  h . h
    double stored(double stress) const { return modulus > 0.0 ? 0.5 * stress / modulus : 0.0; }
};

/// The branches of a series over a time step.
/// @param step  [s], at least 0; a step of no length is a jump, and one of infinite length lets all fade
/// @return shape (B)
std::vector<BranchStep> branch_steps(const PronySeries &relaxation, double step);

/// Factor of the elastic stress at the end of a step in the stress there: remaining() and all gains. The
/// rest of that stress is history: sum over branches of fade h(n) - gain s(n).
double instant_part(const PronySeries &relaxation, const std::vector<BranchStep> &branches);

} // namespace livermark::core
