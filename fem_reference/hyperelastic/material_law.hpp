#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "core/problem.hpp"

namespace livermark::hyperelastic {

using Matrix3 = Eigen::Matrix3d;
/// Second derivative of an energy by the deformation gradient: entry (3 i + J, 3 j + L) is d2 W / d F_iJ d F_jL.
using Tangent = Eigen::Matrix<double, 9, 9>;

/// A measure g of the change of volume J = det F: g = 0 and g' = 1 at J = 1.
struct VolumeMeasure {
    double value;     ///< g
    double slope;     ///< g'
    double curvature; ///< g''
};

/// A hyperelastic material: the energy per volume at rest is
///     W(F) = W_s(F) + k / 2 g(J)^2,   J = det F,
/// with F the deformation gradient, and its first Piola-Kirchhoff stress is P = dW / dF. The second term stands apart
/// because a mixed formulation replaces it by a pressure. Small strains give the linear elasticity of the Material.
/// One file each in materials/, named as the law.
struct MaterialLaw {
    std::string name;    ///< the file stem; set by the table
    std::string summary; ///< half a line
    std::string source;  ///< literature reference
    /// W_s [Pa]
    /// @param f  det F > 0, here and below
    double (*energy)(const core::Material &material, const Matrix3 &f);
    /// d W_s / dF [Pa]
    Matrix3 (*stress)(const core::Material &material, const Matrix3 &f);
    /// d2 W_s / dF2 [Pa]
    Tangent (*tangent)(const core::Material &material, const Matrix3 &f);
    /// @param jacobian  J > 0
    VolumeMeasure (*volume)(double jacobian);
    /// k [Pa]
    double (*volume_modulus)(const core::Material &material);
    /// Number of dimensionless constants that Material::law_constants has to have of it.
    std::size_t num_constants = 0;
};

/// Whether a material has the constants of a law; true of a law that needs none.
bool has_constants(const MaterialLaw &law, const core::Material &material);

/// Every law of materials/, in alphabetical order.
std::span<const MaterialLaw> all_materials();

/// @throws std::invalid_argument if there is no law of this name
const MaterialLaw &material_law(const std::string &name);

/// ln J
inline VolumeMeasure logarithm(double jacobian) {
    return {std::log(jacobian), 1.0 / jacobian, -1.0 / (jacobian * jacobian)};
}

/// lambda [Pa]
inline double lame_lambda(const core::Material &material) {
    return material.lame_lambda();
}

/// I1 bar = J^(-2/3) tr(F^T F), which a change of volume does not change: its value less 3, and two derivatives.
struct IsochoricInvariant {
    double beyond_rest; ///< I1 bar - 3, >= 0
    Matrix3 first;      ///< d I1 bar / dF
    Tangent second;     ///< d2 I1 bar / dF2
};
IsochoricInvariant isochoric_invariant(const Matrix3 &f);

/// Adds factor * d2 J / dF2 and outer * (dJ/dF)(dJ/dF)^T to a tangent, in the indices of Tangent:
/// d2 J / d F_iJ d F_jL = J (G_Ji G_Lj - G_Li G_Jj) with G the inverse of F.
/// @param inverse  G
void add_volume_tangent(double factor, double outer, double jacobian, const Matrix3 &inverse, Tangent &tangent);

/// One term of Ogden's energy in the principal stretches l_i, compressible as the neo-Hookean law is:
///     W_s = 2 mu / a^2 (l_1^a + l_2^a + l_3^a - 3) - 2 mu / a ln J,
/// with the shear modulus mu at small strain and an exponent a. a = 2 is the neo-Hookean law, a = -2 the other term of
/// Mooney and Rivlin. Nothing here becomes singular where stretches coincide.
/// (R. W. Ogden 1972, Large deformation isotropic elasticity: on the correlation of theory and experiment for
/// compressible rubberlike solids, Proc. R. Soc. Lond. A 328, 567-583)
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
