#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "msm/elastic_body.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

/// Energy of springs that are coupled to each other: a hyperelastic material. The squared lengths of the six
/// edges of a tetrahedron give its Green strain E, and so its right Cauchy-Green tensor C = I + 2 E, which is linear in
/// them (tetrahedron.hpp). So any energy of C is one of squared lengths of edges. The energy per volume at rest is
///     W(C) = W_s(C) + (lambda - mu) / 2 g(J)^2,   J^2 = det C,
/// where W_s carries lambda = mu, as springs do, and small strains give linear elasticity. The two parts stand apart
/// because volumes have other domains than strains. One file each in spring_energies/, named as the energy.
struct SpringEnergy {
    std::string name;    ///< the file stem; set by the table
    std::string summary; ///< half a line
    std::string source;  ///< literature reference
    /// W_s [Pa]
    /// @param shear_modulus  mu [Pa], here and below
    /// @param strain         E, symmetric, I + 2 E positive definite, here and below
    double (*energy)(double shear_modulus, const Eigen::Matrix3d &strain);
    /// Second Piola-Kirchhoff stress S = d W_s / dE = 2 d W_s / dC [Pa]
    Eigen::Matrix3d (*stress)(double shear_modulus, const Eigen::Matrix3d &strain);
    /// d2 W_s / dE2 = 4 d2 W_s / dC2 in the components of tetrahedron.hpp [Pa]
    Matrix6 (*stiffness)(double shear_modulus, const Eigen::Matrix3d &strain);
    /// The part of W_s that resists changes of shape alone, and its derivatives as above: its stress has no pressure,
    /// and is what fades in a material that relaxes (RelaxingTerm).
    double (*isochoric_energy)(double shear_modulus, const Eigen::Matrix3d &strain);
    Eigen::Matrix3d (*isochoric_stress)(double shear_modulus, const Eigen::Matrix3d &strain);
    Matrix6 (*isochoric_stiffness)(double shear_modulus, const Eigen::Matrix3d &strain);
    MeasureVolume volume;                    ///< g
    bool is_finite = false;                  ///< whether it has a value where a tetrahedron is inside out, too
    std::vector<StrainMeasure> in_kernels{}; ///< measures with which fast kernels know it
    EnergyFunctions (*kernels)() = nullptr;  ///< in these, see kernels/energy_kernels.hpp
};

/// Every energy of spring_energies/, in alphabetical order.
std::span<const SpringEnergy> all_spring_energies();

} // namespace livermark::msm
