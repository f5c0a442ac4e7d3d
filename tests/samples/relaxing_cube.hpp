#pragma once

#include <algorithm>
#include <cmath>

#include "core/problem.hpp"

namespace livermark::tests {

/// A bar that is pulled along one axis, free to draw in, with one branch of modulus g and time tau on its deviatoric
/// stress, in closed form. In the Laplace domain its Young's modulus is E(a) = 9 K mu a / (3 K + mu a) with
/// a = (1 - g + tau s) / (1 + tau s), which is a standard linear solid again.
struct RelaxingBar {
    core::Material material;
    double modulus, time; ///< g, tau [s]

    double bulk() const { return material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus(); }
    double young_after_all() const {
        const double shear = (1.0 - modulus) * material.shear_modulus();
        return 9.0 * bulk() * shear / (3.0 * bulk() + shear);
    }
    /// Time of the stress at a constant strain [s].
    double relaxation_time() const {
        const double shear = material.shear_modulus();
        return time * (3.0 * bulk() + shear) / (3.0 * bulk() + (1.0 - modulus) * shear);
    }
    /// Stress over the last strain, which is reached linearly at the time `ramp` [Pa].
    double stress(double t, double ramp) const {
        const double rest = young_after_all(), tau = relaxation_time();
        const double fading = (material.young_modulus - rest) * tau / ramp;
        if (t < ramp)
            return rest * t / ramp - fading * std::expm1(-t / tau);
        return rest + fading * std::expm1(ramp / tau) * std::exp(-t / tau);
    }
    /// Strain over the last stress, which is reached linearly at the time `ramp` [1/Pa].
    double strain(double t, double ramp) const {
        const double rest = 1.0 - modulus, tau = time / rest; // of the creep
        const double up_to = std::min(t, ramp);
        // J(t) = 1 / rest - (1 / rest - 1) exp(-t / tau), in the mean over the ramp
        const double creep = up_to / rest - (1.0 / rest - 1.0) * tau * std::exp(-t / tau) * std::expm1(up_to / tau);
        return (up_to / (9.0 * bulk()) + creep / (3.0 * material.shear_modulus())) / ramp;
    }
};

} // namespace livermark::tests
