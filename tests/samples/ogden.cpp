#include "tests/samples/ogden.hpp"

#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::tests {

namespace {

using hyperelastic::Matrix3;
using hyperelastic::OgdenTerm;

template <int exponent> OgdenTerm term(const core::Material &material) {
    return {.shear_modulus = material.shear_modulus(), .exponent = exponent};
}

template <int exponent> OgdenLaw ogden(const char *name) {
    auto law = hyperelastic::material_law("neo_hookean");
    law.name = name;
    law.summary = "one-term Ogden";
    law.source = "R. W. Ogden 1972, Proc. R. Soc. Lond. A 328, 567-583";
    law.energy = [](const core::Material &material, const Matrix3 &f) { return term<exponent>(material).energy(f); };
    law.stress = [](const core::Material &material, const Matrix3 &f) { return term<exponent>(material).stress(f); };
    law.tangent = [](const core::Material &material, const Matrix3 &f) { return term<exponent>(material).tangent(f); };
    return {exponent, law};
}

} // namespace

std::vector<OgdenLaw> ogden_laws() {
    return {ogden<-4>("ogden_minus_4"), ogden<-2>("ogden_minus_2"), ogden<2>("ogden_2"), ogden<8>("ogden_8")};
}

} // namespace livermark::tests
