#pragma once

#include <span>
#include <vector>

#include "core/load_case.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"

namespace livermark::hyperelastic {

/// dW / dF of the whole energy, including the volume term: first Piola-Kirchhoff stress [Pa].
/// @param f  det F > 0
Matrix3 whole_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f);

/// d2 W / dF2 of the whole energy, including the volume term.
/// @param f  det F > 0
/// @return [Pa]
Tangent whole_tangent(const MaterialLaw &law, const core::Material &material, const Matrix3 &f);

/// Adds what a pressure that follows the surface contributes. It has the potential p V, and the half space is deformed
/// evenly, so that p J may stand in its energy.
/// @param pressure  p [Pa], positive inwards
void add_follower_pressure(double pressure, const Matrix3 &f, Tangent &tangent);

/// Resistance of an evenly deformed half space to short waves of its surface, when the tractions on the surface keep
/// their direction and size per area at rest. A wave a exp(i k t . x) of the surface, and below it what has the least
/// energy, takes the energy k / 2 a* Z a per area, with the surface impedance Z of the direction t. Where Z is not
/// positive definite, waves grow by themselves, however short they are: no mesh resolves them, and finer meshes find
/// equilibria of lower energy, or none (the complementing condition fails; H. C. Simpson, S. J. Spector 1987, On the
/// positivity of the second variation in finite elasticity, Arch. Ration. Mech. Anal. 98). Without a traction that is
/// M. A. Biot's limit (1963, Surface instability of rubber in compression, Appl. Sci. Res. A 12). Z is
/// H^-1 + i H^-1 S, with the matrices S and H of D. M. Barnett and J. Lothe (1973, Synthesis of the sextic and the
/// integral formalism for dislocations, Greens functions, and surface waves in anisotropic elastic solids, Phys. Norv.
/// 7).
/// @param tangent  d2 W / dF2 [Pa], also of other moduli
/// @param normal   of the surface at rest, outwards, of length 1
/// @return least eigenvalue of Z, over 12 directions t [Pa]; NaN where the material itself is not elliptic
double least_surface_impedance(const Tangent &tangent, const Eigen::Vector3d &normal);

/// The body at the centroid of a boundary triangle.
struct SurfacePoint {
    core::Vector3 at_rest; ///< [m]
    core::Vector3 normal;  ///< at rest, outwards, of length 1
    double area = 0.0;     ///< of the triangle at rest [m^2]
    Matrix3 deformation;   ///< F
    core::Material material;
};

/// @param displacement  shape (3 n) [m], of quadratic elements
/// @return shape (T)
std::vector<SurfacePoint> surface_points(const Elements &elements, std::span<const double> displacement);

/// F of a surface whose stretches and shears along itself are these, and on which a traction acts: what is across the
/// surface follows from P N = t. It has none of the error of a pressure that is not that of F, as in mixed elements.
/// @param traction  t, per area at rest [Pa]
/// @return not finite where no such F is found
Matrix3 under_traction(const MaterialLaw &law, const SurfacePoint &point, const core::Vector3 &traction);

/// Part of the area under tractions that keep their direction, where the surface cannot resist short waves (see
/// least_surface_impedance()): the problem itself has no stable solution there, whatever the mesh.
/// @param load_case  on the mesh of the elements, which are quadratic
/// @param factor     that its tractions are multiplied by: a fraction of the load, or newtons where places press
/// @return 0 where there are no such tractions
double unstable_part(const Elements &elements, const core::LoadCase &load_case, std::span<const double> displacement,
                     double factor);

/// Least and largest stretch of all directions in the surface.
struct SurfaceStretches {
    double least = 1.0, largest = 1.0;
};
SurfaceStretches surface_stretches(const SurfacePoint &point);

} // namespace livermark::hyperelastic
