#pragma once

#include <string>
#include <vector>

namespace livermark::core {

/// How tissue relaxes: quasi-linear viscoelasticity with a Prony series (Fung, Biomechanics, 1993, ch. 7; Simo and
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
};

/// What drives a body that relaxes, so slowly that masses do not matter: everything that grows along a path grows with
/// `factors`, linearly between the times.
struct SlowHistory {
    PronySeries relaxation;
    std::vector<double> times;   ///< (K) at which solutions are found [s], ascending from 0
    std::vector<double> factors; ///< (K) of the loads; 0 at the start
    int num_records() const { return static_cast<int>(times.size()); }
};

} // namespace livermark::core
