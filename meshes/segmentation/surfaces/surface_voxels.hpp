#pragma once

#include <vector>

#include "meshes/generators/surface_mesh.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// The voxels within surfaces: the first is the liver, each other a lesion. Lesions win, and of two the smaller; they
/// end at the liver's surface. Remarks say what is shared or left out.
/// @param surfaces  closed [m]; of several parts the union counts
/// @param spacing   of the cubes [m]
/// @throws support::InputError  if a lesion has no voxel inside the liver or of its own, which is named by its number,
///                           if no other tissue is left, or if the box around the liver takes more than 2^28 voxels
Segmentation voxels_within(const std::vector<meshes::SurfaceMesh> &surfaces, double spacing);

} // namespace livermark::segmentation
