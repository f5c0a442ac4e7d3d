#pragma once

#include <vector>

#include "meshes/anatomy/liver_registration.hpp"

namespace livermark::meshes {

/// A part of the boundary of a body: facets that stand for equal parts of the area.
struct BoundarySample {
    core::Vector3 place; ///< [m]
    core::Vector3 area;  ///< outward area vector [m^2]
};

/// Mean square of the distance of samples from the capsule of fit.shape [m^2], and of what their normals are off. No
/// distance counts more than 40 mm; a normal that is a right angle off counts as 15 mm.
double boundary_misfit(const LiverFit &fit, const std::vector<BoundarySample> &samples);

/// Bends the liver that ships until its capsule lies on the boundary of a body, from a fit that is near.
///
/// Least squares by Levenberg and Marquardt's method, in which an affine map and the lengths of LiverShape are unknown:
///   boundary_misfit + (1 mm)^2 (|t|^2 + |h|^2 / 0.15^2)
/// where t are lengths of the shape in units of how far they vary from liver to liver (draw_liver()), and h is the
/// logarithmic strain of the map without its change of volume. fit.distance becomes the square root of the sum.
/// @param samples  of the boundary of the body
/// @param has_tongue  whether the liver has a Riedel's lobe, whose length is then unknown too
LiverFit adjusted(const LiverFit &fit, const std::vector<BoundarySample> &samples, bool has_tongue);

} // namespace livermark::meshes
