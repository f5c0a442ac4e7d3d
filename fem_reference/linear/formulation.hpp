#pragma once

namespace livermark::fem_reference {

/// What is unknown.
enum class Formulation {
    displacement, ///< u alone
    mixed         ///< and the pressure p = lambda div u of what is nearly incompressible, see PressureSystem
};

} // namespace livermark::fem_reference
