#pragma once

#include <vector>

#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::hyperelastic {

/// What relaxation adds to the energy per volume of a point in one time step:
///     - faded W_s(F') + 1/2 H : (C' - I),   F' = J^(-1/3) F,   C' = F'^T F',
/// so that the isochoric part of the law is multiplied by 1 - faded = core::instant_part(), and what the branches
/// remember pushes along: a potential, although relaxation has none over several steps.
/// (J. C. Simo 1987, On a fully three-dimensional finite-strain viscoelastic damage model, Comput. Methods Appl. Mech.
/// Eng. 60; Simo and Hughes, Computational Inelasticity, 1998, section 10.3)
struct IsochoricPart {
    const MaterialLaw &law;
    const core::Material &material;
    double faded;
    const Matrix3 &remembered; ///< H, symmetric [Pa]

    /// [Pa]
    /// @param f  det F > 0, here and below
    double energy(const Matrix3 &f) const;
    /// Its derivative by F [Pa].
    Matrix3 stress(const Matrix3 &f) const;
    /// Its second derivative [Pa].
    Tangent tangent(const Matrix3 &f) const;
};

/// What the branches follow: the deviator S - (S : C') / 3 C'^-1 of S = 2 d W_s / dC' at C', symmetric [Pa]. At small
/// strains twice the shear modulus times the deviatoric strain.
Matrix3 isochoric_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f);

/// A time step at all points of integration of a body.
struct DeviatoricMemory {
    double faded = 0.0;                ///< 1 - core::instant_part()
    std::vector<Matrix3> remembered{}; ///< H at each point, cell by cell: sum over branches of fade h(n) - gain s(n)
};

} // namespace livermark::hyperelastic
