#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "meshes/surface_mesh.hpp"
#include "segmentation/segmentation.hpp"

namespace livermark::segmentation {

/// Reads a closed triangulated surface: STL, OBJ or PLY. Corners in the same place become one, and the triangles are
/// turned so that they look outwards.
/// @return coordinates as they are in the file
/// @throws support::InputError  with the file, the place and a remedy: not such a file, no triangles, coordinates that
/// are
///                           no numbers, open edges, triangles that cut each other
meshes::SurfaceMesh read_surface(const std::filesystem::path &file);

/// The voxels within surfaces: the first is the liver, each other a lesion (they win where they overlap, the later
/// over the earlier, and end at the liver's surface).
/// @param surfaces  [m]
/// @param spacing   of the cubes [m]
/// @throws support::InputError  if a lesion has no voxel inside the liver, which is named by its number, or if the box
/// around
///                           the liver takes more than 2^28 voxels
Segmentation voxels_within(const std::vector<meshes::SurfaceMesh> &surfaces, double spacing);

} // namespace livermark::segmentation
