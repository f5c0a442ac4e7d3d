#pragma once

#include <string>
#include <vector>

#include "core/tetra_mesh.hpp"

namespace livermark::meshes {

/// Finds the patches of a liver that a mesh has no names for, so that the load cases that ship can be put on it:
/// posterior, right_lobe_dome, superior, left_lobe_tip, anterior, inferior and right_lateral. The mesh has to stand
/// about as a patient does, x to the left, y to the back and z up (LPS, the axes of medical images).
///
/// The rules are in the frame of the principal axes of the volume, each named after the nearest axis of the mesh, where
/// places are parts of the bounding box, from 0 to 1. They were drawn on the livers that ship. A facet goes to the
/// first rule that it meets; a facet that the file itself gives to a patch of these names stays there.
/// @return a sentence for each patch that was found, with the rule and the area
std::vector<std::string> find_anatomical_patches(core::TetraMesh &mesh);

} // namespace livermark::meshes
