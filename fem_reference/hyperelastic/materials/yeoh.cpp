#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::hyperelastic::materials {

namespace {

/// Terms that are added to a neo-Hookean material: mu / 2 (c2 x^2 + c3 x^3) with x = I1 bar - 3.
struct YeohTerms {
    explicit YeohTerms(const core::Material &material)
        : half_modulus(0.5 * material.shear_modulus()), c2(material.law_constants.at("yeoh").at(0)),
          c3(material.law_constants.at("yeoh").at(1)) {}

    double energy(double x) const { return half_modulus * x * x * (c2 + c3 * x); }
    double slope(double x) const { return half_modulus * x * (2.0 * c2 + 3.0 * c3 * x); }
    double curvature(double x) const { return half_modulus * (2.0 * c2 + 6.0 * c3 * x); }

    double half_modulus, c2, c3;
};

OgdenTerm neo_hookean_part(const core::Material &material) {
    return {.shear_modulus = material.shear_modulus(), .exponent = 2.0};
}

double yeoh_energy(const core::Material &material, const Matrix3 &f) {
    return neo_hookean_part(material).energy(f) + YeohTerms(material).energy(isochoric_invariant(f).beyond_rest);
}

Matrix3 yeoh_stress(const core::Material &material, const Matrix3 &f) {
    const auto invariant = isochoric_invariant(f);
    return neo_hookean_part(material).stress(f) + YeohTerms(material).slope(invariant.beyond_rest) * invariant.first;
}

Tangent yeoh_tangent(const core::Material &material, const Matrix3 &f) {
    const auto invariant = isochoric_invariant(f);
    const YeohTerms terms(material);
    Eigen::Matrix<double, 9, 1> first;
    for (int i = 0; i < 3; ++i)
        for (int big_j = 0; big_j < 3; ++big_j)
            first[3 * i + big_j] = invariant.first(i, big_j);
    return neo_hookean_part(material).tangent(f) + terms.slope(invariant.beyond_rest) * invariant.second +
           terms.curvature(invariant.beyond_rest) * first * first.transpose();
}

} // namespace

/// W = mu / 2 (I1 - 3 - 2 ln J + c2 x^2 + c3 x^3) + lambda / 2 (ln J)^2 with x = J^(-2/3) I1 - 3. In the paper
/// c2 = C20 / C10 and c3 = C30 / C10.
MaterialLaw yeoh() {
    return {.name = {},
            .summary = "Yeoh's, with two constants of the material: it stiffens under large deformations",
            .source = "Yeoh 1993, Some forms of the strain energy function for rubber, Rubber Chem. Technol. 66(5)",
            .energy = yeoh_energy,
            .stress = yeoh_stress,
            .tangent = yeoh_tangent,
            .volume = logarithm,
            .volume_modulus = lame_lambda,
            .num_constants = 2};
}

} // namespace livermark::hyperelastic::materials
