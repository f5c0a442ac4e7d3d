#pragma once

#include <span>
#include <vector>

#include "core/load_case.hpp"
#include "fem_reference/hyperelastic/elements.hpp"

namespace livermark::hyperelastic {

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
