#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::hyperelastic::materials {

namespace {

/// The paper below fits mu and a to uniaxial tension of ten samples of porcine liver. An open re-implementation of it,
/// github.com/gk408829/Hyperelastic-Image-Registration, has mu = 72.095 Pa and a = 5.4067. Only this exponent is used,
/// which says how much tissue stiffens; how stiff it is at rest, the material's Young's modulus says.
constexpr double exponent_of_liver = 5.4067;

OgdenTerm term(const core::Material &material) {
    const auto own = material.law_constants.find("ogden");
    return {.shear_modulus = material.shear_modulus(),
            .exponent = own != material.law_constants.end() ? own->second.at(0) : exponent_of_liver};
}

double ogden_energy(const core::Material &material, const Matrix3 &f) {
    return term(material).energy(f);
}

Matrix3 ogden_stress(const core::Material &material, const Matrix3 &f) {
    return term(material).stress(f);
}

Tangent ogden_tangent(const core::Material &material, const Matrix3 &f) {
    return term(material).tangent(f);
}

} // namespace

/// W = 2 mu / a^2 (l_1^a + l_2^a + l_3^a - 3) - 2 mu / a ln J + lambda / 2 (ln J)^2 with the principal stretches l_i.
/// A material may have an exponent of its own.
MaterialLaw ogden() {
    return {.name = {},
            .summary = "Ogden's with one term, which stiffens as porcine liver does",
            .source = "Gao, Desai 2010, Estimating zero-strain states of very soft tissue under gravity loading using "
                      "digital image correlation, Med. Image Anal. 14(2), 126-137, PMC2822045",
            .energy = ogden_energy,
            .stress = ogden_stress,
            .tangent = ogden_tangent,
            .volume = logarithm,
            .volume_modulus = lame_lambda};
}

} // namespace livermark::hyperelastic::materials
