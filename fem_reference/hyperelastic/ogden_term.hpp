#pragma once

#include "fem_reference/hyperelastic/material_law.hpp"

/// One term of Ogden's energy in the principal stretches l_i, compressible as the neo-Hookean law is:
///     W_s = 2 mu / a^2 (l_1^a + l_2^a + l_3^a - 3) - 2 mu / a ln J,
/// with the shear modulus mu at small strain and an exponent a. a = 2 is the neo-Hookean law, a = -2 the other term of
/// Mooney and Rivlin. Nothing here becomes singular where stretches coincide.
/// (R. W. Ogden 1972, Large deformation isotropic elasticity: on the correlation of theory and experiment for
/// compressible rubberlike solids, Proc. R. Soc. Lond. A 328, 567-583)
namespace livermark::hyperelastic {

/// One term of Ogden's energy.
struct OgdenTerm {
    double shear_modulus; ///< mu [Pa]
    double exponent;      ///< a, not 0

    /// W_s [Pa]
    /// @param f  deformation gradient, det F > 0, here and below
    double energy(const Matrix3 &f) const;
    /// d W_s / dF [Pa]
    Matrix3 stress(const Matrix3 &f) const;
    /// d2 W_s / dF2 [Pa]
    Tangent tangent(const Matrix3 &f) const;
};

} // namespace livermark::hyperelastic
