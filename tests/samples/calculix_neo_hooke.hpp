#pragma once

#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::tests {

/// The energy of CalculiX's *HYPERELASTIC, NEO HOOKE,
///     W = C10 (J^(-2/3) I1 - 3) + (J - 1)^2 / D1,   C10 = mu / 2, D1 = 2 / kappa, kappa = lambda + 2 mu / 3,
/// which is not that of the project's law of the same name.
/// (G. Dhondt, CalculiX CrunchiX User's Manual, section *HYPERELASTIC)
hyperelastic::MaterialLaw calculix_neo_hooke();

} // namespace livermark::tests
