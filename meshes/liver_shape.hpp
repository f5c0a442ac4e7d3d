#pragma once

#include <array>
#include <vector>

#include "core/tetra_mesh.hpp"

namespace livermark::meshes {

/// Axes of all liver functions: LPS as in DICOM, x to the patient's left, y posterior, z superior [m]; the origin is
/// near the centroid.

/// Level function of the liver: negative inside, positive outside, zero on the capsule, and close to the signed
/// distance [m] near it. A smooth blend of ellipsoids, cylinders and planes written with + - * / sqrt alone, which IEEE
/// 754 rounds in one way only, so that the same liver comes out wherever it is built (exp, sin and pow do not promise
/// that).
/// @param point  [m]
double liver_level(const core::Vector3 &point);

/// How deep a point lies under the convex side, before stomach, kidney and the other neighbours press in [m]: near zero
/// on the diaphragmatic surface, positive on the visceral one.
double diaphragmatic_depth(const core::Vector3 &point);

/// Gradient of the level function by central differences: outward and close to unit length near the capsule.
core::Vector3 liver_gradient(const core::Vector3 &point);

/// The point of the capsule reached from a nearby point by Newton steps along the normal.
core::Vector3 project_to_liver(core::Vector3 point);

/// Corners of a box [m] that holds the whole capsule.
std::array<core::Vector3, 2> liver_bounding_box();

/// An ellipsoidal lesion.
struct Lesion {
    core::Vector3 center;              ///< [m]
    core::Vector3 semi_axes;           ///< [m]
    std::array<core::Vector3, 3> axes; ///< orthonormal, right-handed
};

/// The six lesions of the body with tumours, largest first: 49 to 12 mm across, in both lobes.
std::vector<Lesion> liver_lesions();

} // namespace livermark::meshes
