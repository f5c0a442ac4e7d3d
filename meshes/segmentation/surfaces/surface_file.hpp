#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "meshes/generators/surface_mesh.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// Reads a closed triangulated surface: STL, OBJ, PLY or OFF, and, after scripts/convert_surface, VTK and VTP polydata
/// and what meshio reads. Readers and repairs run in a
/// process of their own, which may fail on a damaged file. Of tetrahedra the boundary is taken. Corners in the same
/// place become one, the triangles are turned so that they look outwards, and what is not as it should be is repaired:
/// see closed_parts(). Files in which 3D Slicer has written that they are RAS are turned to LPS.
/// @param remarks  gets a sentence for each change
/// @return coordinates as they are in the file, but for that; of several parts that cut each other the union counts
/// @throws support::InputError  with the file, the place and a remedy: not such a file, no triangles, coordinates that
///                           are no numbers, open edges, triangles that cut each other and cannot be repaired
meshes::SurfaceMesh read_surface(const std::filesystem::path &file, std::vector<std::string> &remarks);

/// Reads a file of lesions in the same way: each closed part by itself is one, the largest first, and parts that cut
/// each other are one together.
std::vector<meshes::SurfaceMesh> read_lesions(const std::filesystem::path &file, std::vector<std::string> &remarks);

/// The voxels within surfaces: the first is the liver, each other a lesion. Lesions win, and of two the smaller; they
/// end at the liver's surface. Remarks say what is shared or left out.
/// @param surfaces  closed [m]; of several parts the union counts
/// @param spacing   of the cubes [m]
/// @throws support::InputError  if a lesion has no voxel inside the liver or of its own, which is named by its number,
///                           if no other tissue is left, or if the box around the liver takes more than 2^28 voxels
Segmentation voxels_within(const std::vector<meshes::SurfaceMesh> &surfaces, double spacing);

} // namespace livermark::segmentation
