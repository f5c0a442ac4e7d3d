#pragma once

namespace livermark::core {

/// Isotropic linear-elastic material.
struct Material {
    double density;       ///< rho [kg/m^3], > 0
    double young_modulus; ///< E [Pa], > 0
    double poisson_ratio; ///< nu, in (-1, 0.5)

    /// First Lame parameter, lambda = E nu / ((1 + nu)(1 - 2 nu)) [Pa].
    double lame_lambda() const {
        return young_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
    }
    /// Shear modulus, mu = E / (2 (1 + nu)) [Pa].
    double shear_modulus() const { return young_modulus / (2.0 * (1.0 + poisson_ratio)); }
};

} // namespace livermark::core
