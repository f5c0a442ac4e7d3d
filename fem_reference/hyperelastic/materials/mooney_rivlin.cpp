#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::hyperelastic::materials {

namespace {

/// The two terms, with exponents 2 and -2.
struct MooneyRivlinTerms {
    explicit MooneyRivlinTerms(const core::Material &material)
        : part(material.law_constants.at("mooney_rivlin").at(0)), first{.shear_modulus =
                                                                            (1.0 - part) * material.shear_modulus(),
                                                                        .exponent = 2.0},
          second{.shear_modulus = part * material.shear_modulus(), .exponent = -2.0} {}

    double part;
    OgdenTerm first, second;
};

double mooney_energy(const core::Material &material, const Matrix3 &f) {
    const MooneyRivlinTerms terms(material);
    return terms.first.energy(f) + terms.second.energy(f);
}

Matrix3 mooney_stress(const core::Material &material, const Matrix3 &f) {
    const MooneyRivlinTerms terms(material);
    return terms.first.stress(f) + terms.second.stress(f);
}

Tangent mooney_tangent(const core::Material &material, const Matrix3 &f) {
    const MooneyRivlinTerms terms(material);
    return terms.first.tangent(f) + terms.second.tangent(f);
}

} // namespace

/// W = mu / 2 ((1 - c) (I1 - 3 - 2 ln J) + c (tr C^-1 - 3 + 2 ln J)) + lambda / 2 (ln J)^2. Where the volume stays,
/// tr C^-1 is I2, and c = C01 / (C10 + C01) of the paper.
MaterialLaw mooney_rivlin() {
    return {.name = {},
            .summary = "that of Mooney and Rivlin, with one constant of the material",
            .source = "Rivlin, Saunders 1951, Large elastic deformations of isotropic materials VII, Philos. Trans. R. "
                      "Soc. A 243(865)",
            .energy = mooney_energy,
            .stress = mooney_stress,
            .tangent = mooney_tangent,
            .volume = logarithm,
            .volume_modulus = lame_lambda,
            .num_constants = 1};
}

} // namespace livermark::hyperelastic::materials
