#pragma once

#include <vector>

#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::tests {

/// The law of hyperelastic::OgdenTerm, with an exponent that is chosen for tests and is no fit to a tissue.
struct OgdenLaw {
    double exponent;
    hyperelastic::MaterialLaw law;
};

/// Exponents -4, -2, 2 and 8. With 2 the law is neo-Hookean; with -2 it is the other term of Mooney and Rivlin,
///     W_s = mu / 2 (tr C^-1 - 3 + 2 ln J);
/// those beyond stiffen more in compression and in tension.
std::vector<OgdenLaw> ogden_laws();

} // namespace livermark::tests
