#pragma once

#include <vector>

#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::tests {

/// One-term Ogden law of exponent a in the principal stretches l_i, compressible as the project's neo-Hookean law is:
///     W = 2 mu / a^2 (l_1^a + l_2^a + l_3^a - 3) - 2 mu / a ln J + lambda / 2 (ln J)^2.
/// Its exponents are chosen for tests and are no fit to a tissue.
/// (R. W. Ogden 1972, Large deformation isotropic elasticity: on the correlation of theory and experiment for
/// compressible rubberlike solids, Proc. R. Soc. Lond. A 328, 567-583)
struct OgdenLaw {
    int exponent;
    hyperelastic::MaterialLaw law;
};

/// Exponents -4, -2, 2 and 8. With 2 the law is neo-Hookean; with -2 it is the other term of Mooney and Rivlin,
///     W_s = mu / 2 (tr C^-1 - 3 + 2 ln J);
/// those beyond stiffen more in compression and in tension.
std::vector<OgdenLaw> ogden_laws();

} // namespace livermark::tests
