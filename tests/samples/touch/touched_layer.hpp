#pragma once

#include <cmath>
#include <numbers>

#include "core/problem.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark::tests {

/// A layer that sticks to its floor and a rigid ball without friction, with a closed form for small deformations.
struct TouchedLayer {
    static constexpr double young_modulus = 5e3, thickness = 0.02, radius = 0.03; ///< [Pa, m, m]

    double poisson_ratio = 0.3;
    int bricks_down = 3; ///< of cubes; three times as many across

    /// Force on the ball: that of Hertz times a series in the radius of contact over the thickness [N]. (Dimitriadis et
    /// al. 2002, Biophys. J. 82, equations 12 and 13)
    /// @param sunk  [m]
    static double force(double nu, double sunk) {
        const double pi = std::numbers::pi;
        const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
        const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1.0 - nu);
        const double chi = std::sqrt(radius * sunk) / thickness;
        const double hertz = 4.0 / 3.0 * young_modulus / (1.0 - nu * nu) * std::sqrt(radius) * std::pow(sunk, 1.5);
        return hertz * (1.0 - 2.0 * a / pi * chi + std::pow(2.0 * a / pi * chi, 2) -
                        8.0 / std::pow(pi, 3) * (std::pow(a, 3) + 4.0 * pi * pi / 15.0 * b) * std::pow(chi, 3) +
                        16.0 * a / std::pow(pi, 4) * (std::pow(a, 3) + 3.0 * pi * pi / 5.0 * b) * std::pow(chi, 4));
    }

    /// @param sunk   [m]
    /// @param aside  of the ball from the middle of the top, which is a node where there are evenly many bricks [m]
    core::Problem problem(double sunk, const core::Vector3 &aside = {1e-4, 2e-4, 0.0}) const {
        TouchedBlock block;
        block.size = {3.0 * thickness, 3.0 * thickness, thickness};
        block.bricks = {3 * bricks_down, 3 * bricks_down, bricks_down};
        block.poisson_ratio = poisson_ratio;
        block.shape = radius;
        block.press = {0.0, 0.0, -sunk};
        block.aside = aside;
        block.path = {0.5, 1.0};
        return touched_block(block);
    }
};

} // namespace livermark::tests
