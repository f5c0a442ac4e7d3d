#pragma once

#include <cmath>
#include <numbers>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::tests {

/// A rigid ball on an elastic half-space below z = 0 (K. L. Johnson, Contact Mechanics, 1985, chapters 3, 4 and 7), in
/// metres: so shallow that strains and slopes are a hundredth.
struct HalfSpace {
    static constexpr double ball_radius = 1.0, depth = 1e-4, modulus = 5000.0;
    double poisson;

    double shear_modulus() const { return 0.5 * modulus / (1.0 + poisson); }
    double contact_radius() const { return std::sqrt(ball_radius * depth); }
    /// 4/3 E* sqrt(R) d^(3/2)
    double force() const {
        return 4.0 / 3.0 * modulus / (1.0 - poisson * poisson) * std::sqrt(ball_radius) * std::pow(depth, 1.5);
    }
    /// Way of the ball along the surface at which all of it slips: 3 mu P (2 - nu) / (16 G a).
    double way_to_slip(double friction) const {
        return 3.0 * friction * force() * (2.0 - poisson) / (16.0 * shear_modulus() * contact_radius());
    }

    /// Displacement by a force P into the half-space at the origin (Boussinesq).
    core::Vector3 pressed(double force, const core::Vector3 &x) const {
        const double down = -x.z(), rho = x.norm();
        const double along = down / std::pow(rho, 3) - (1.0 - 2.0 * poisson) / (rho * (rho + down));
        return force / (4.0 * std::numbers::pi * shear_modulus()) *
               core::Vector3(x.x() * along, x.y() * along,
                             -(2.0 * (1.0 - poisson) / rho + down * down / std::pow(rho, 3)));
    }
    /// Displacement by a force Q along x at the origin (Cerruti).
    core::Vector3 dragged(double force, const core::Vector3 &x) const {
        const double down = -x.z(), rho = x.norm(), sum = rho + down, cube = std::pow(rho, 3);
        const double rest = 1.0 - 2.0 * poisson;
        return force / (4.0 * std::numbers::pi * shear_modulus()) *
               core::Vector3(1.0 / rho + x.x() * x.x() / cube + rest * (1.0 / sum - x.x() * x.x() / (rho * sum * sum)),
                             x.x() * x.y() / cube - rest * x.x() * x.y() / (rho * sum * sum),
                             -(x.x() * down / cube + rest * x.x() / (rho * sum)));
    }
};

/// A rigid round punch on that half-space whose flat face ends in parabolas of a radius of curvature (I. N. Sneddon
/// 1965, The relation between load and penetration in the axisymmetric Boussinesq problem for a punch of arbitrary
/// profile, Int. J. Eng. Sci. 3; M. Ciavarella, D. A. Hills, G. Monno 1998, The influence of rounded edges on
/// indentation by a flat punch, Proc. Inst. Mech. Eng. C 212). It touches in a radius c = a / cos(phi).
struct RoundedPunch {
    double size, edge_radius; ///< a, r [m]

    double contact_radius(double phi) const { return size / std::cos(phi); }
    /// c^2 / r (sin(phi) - phi cos(phi))
    double depth(double phi) const {
        return std::pow(contact_radius(phi), 2) / edge_radius * (std::sin(phi) - phi * std::cos(phi));
    }
    /// Force over E*: 2 c^2 / r (c (sin(phi) - sin(phi)^3 / 3) - a (phi + sin(phi) cos(phi)) / 2) [m^2]. Without edges
    /// it is Boussinesq's 2 a d.
    double force(double phi) const {
        const double c = contact_radius(phi), sine = std::sin(phi);
        return 2.0 * c * c / edge_radius *
               (c * (sine - std::pow(sine, 3) / 3.0) - 0.5 * size * (phi + sine * std::cos(phi)));
    }
    double phi_at(double depth_to_reach) const {
        double low = 0.0, high = 1.5;
        for (int halving = 0; halving < 60; ++halving)
            (depth(0.5 * (low + high)) < depth_to_reach ? low : high) = 0.5 * (low + high);
        return low;
    }
};

} // namespace livermark::tests
