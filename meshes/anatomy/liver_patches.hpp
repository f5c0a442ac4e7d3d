#pragma once

#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/anatomy/liver_registration.hpp"
#include "meshes/generators/liver/liver_shape.hpp"

namespace livermark::meshes {

/// posterior, anterior, inferior, superior, right_lobe_dome, right_lateral and left_lobe_tip.
std::vector<std::string> liver_patch_names();

/// Finds the boundary of a liver in the axes of liver_level and divides it into connected patches, by where a facet
/// lies and looks:
///   posterior        bare area, groove of the vena cava and caudate lobe: where the liver is constrained
///   anterior         under the ribs, both lobes
///   inferior         visceral side, gallbladder fossa and porta hepatis
///   superior         left lobe and middle, under the diaphragm and the heart
///   right_lobe_dome  top of the right lobe, under the diaphragm
///   right_lateral    right side, along the ribs
///   left_lobe_tip    all around the end of the left lobe
/// Replaces boundary_triangles, boundary_patch and patch_names. Borders are smoothed by the majority of neighbours, and
/// islands go to the patch around them, so each patch is in one piece.
void assign_liver_patches(core::TetraMesh &mesh);

/// The same for a liver that lies elsewhere, whose boundary is there and stays.
/// The tip is at least half as long as that of the shape, also where the left lobe ends sooner.
/// @param fit  where it lies in the axes of liver_level, and its shape there
void assign_liver_patches(core::TetraMesh &mesh, const LiverFit &fit);

/// The same by the same rules for a liver of another shape, in the axes of liver_level: its boundary is found, and the
/// tip begins where the left lobe of that shape narrows.
void assign_liver_patches(core::TetraMesh &mesh, const LiverShape &shape);

} // namespace livermark::meshes
