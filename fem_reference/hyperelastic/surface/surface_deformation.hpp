#pragma once

#include <span>
#include <vector>

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

/// Least and largest stretch of all directions in the surface.
struct SurfaceStretches {
    double least = 1.0, largest = 1.0;
};
SurfaceStretches surface_stretches(const SurfacePoint &point);

} // namespace livermark::hyperelastic
