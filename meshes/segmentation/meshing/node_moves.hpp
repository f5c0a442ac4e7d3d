#pragma once

#include <vector>

#include "meshes/segmentation/meshing/label_domain.hpp"

namespace livermark::segmentation {

/// Moves of nodes that leave the connections as they are.

/// Moves the nodes of all borders onto the level sets of the domain, as far as their tetrahedra stay fair.
void snap_to_levels(core::TetraMesh &mesh, const LabelDomain &domain);

/// Hill climbing: every node at a tetrahedron below this quality goes where the worst of its tetrahedra is better.
/// Nodes of borders slide along the level set that they are on, which need not be that of the border.
void climb(core::TetraMesh &mesh, const LabelDomain &domain, double quality);

/// Moves the nodes of the borders along their normals, evenly, until each region has the volume wanted: Newton's steps,
/// each the smallest change (weighted with the area) that the derivatives of all volumes ask for together. What a step
/// would make worse than fair is left, so that volumes may be missed.
/// @param wanted  (R) [m^3]
void correct_volumes(core::TetraMesh &mesh, const std::vector<double> &wanted);

/// @return (num_regions) [m^3]
std::vector<double> volumes_of_regions(const core::TetraMesh &mesh, std::size_t num_regions);

} // namespace livermark::segmentation
