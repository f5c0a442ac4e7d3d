#pragma once

#include <cmath>

#include "interactive/elements/energies/densities.hpp"

/// The laws of Bullet's tetrahedra, as its headers have them, in double precision: energies per volume as those of
/// interactive/elements/energies/densities.hpp. Its third law, btDeformableLinearElasticityForce, is
/// interactive::densities::Corotational but for the rotation that it takes.
namespace livermark::benchmarks::bullet_laws {

using interactive::Matrix3;
using interactive::densities::Tangent;

/// btDeformableNeoHookeanForce: W = mu / 2 (I1 - 3 - ln(I1 + 1)) + lambda / 2 (J - 1 - 3 mu / (4 lambda))^2.
/// (Smith, De Goes, Kim 2018, Stable neo-Hookean flesh simulation, ACM TOG 37(2), eq. 14)
struct NeoHookean {
    double mu, lambda;

    /// What gives small strains the Lame parameters of a material: 4/3 mu and lambda + 5/6 mu.
    /// (the same, eq. 16)
    static NeoHookean of_material(double mu, double lambda) {
        return {.mu = 4.0 / 3.0 * mu, .lambda = lambda + 5.0 / 6.0 * mu};
    }

    double value(const Matrix3 &f) const {
        const double square = f.squaredNorm(), growth = f.determinant() - 1.0 - 0.75 * mu / lambda;
        return 0.5 * mu * (square - 3.0 - std::log(square + 1.0)) + 0.5 * lambda * growth * growth;
    }
    Matrix3 stress(const Matrix3 &f) const { return shear(f) * f + pressure(f) * interactive::cofactors(f); }
    Tangent tangent(const Matrix3 &f) const {
        const Eigen::Matrix<double, 9, 1> c = interactive::densities::by_columns(interactive::cofactors(f)),
                                          a = interactive::densities::by_columns(f);
        const double base = f.squaredNorm() + 1.0;
        return shear(f) * Tangent::Identity() + 2.0 * mu / (base * base) * a * a.transpose() +
               lambda * c * c.transpose() + pressure(f) * interactive::densities::determinant_tangent(f);
    }

  private:
    double shear(const Matrix3 &f) const { return mu * (1.0 - 1.0 / (f.squaredNorm() + 1.0)); }
    double pressure(const Matrix3 &f) const { return lambda * (f.determinant() - 1.0) - 0.75 * mu; }
};

/// btDeformableCorotatedForce: W = mu |F - R|^2 + lambda / 2 (J - 1)^2. Only its stress: Bullet has no more of it
/// either.
struct Corotated {
    double mu, lambda;

    Matrix3 stress(const Matrix3 &f) const {
        return 2.0 * mu * (f - interactive::densities::rotation(f)) +
               lambda * (f.determinant() - 1.0) * interactive::cofactors(f);
    }
};

} // namespace livermark::benchmarks::bullet_laws
