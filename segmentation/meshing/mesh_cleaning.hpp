#pragma once

#include "segmentation/images/label_pieces.hpp"

namespace livermark::segmentation {

/// The tetrahedra of each part of a region that hangs together across faces, largest part first.
std::vector<std::vector<int>> mesh_pieces(const core::TetraMesh &mesh);

/// How many more or fewer pieces the regions have in the mesh than wanted, all in all.
int num_wrong_pieces(const core::TetraMesh &mesh, const std::vector<LabelPiece> &wanted);

/// Places where the boundary is not a manifold: edges that other than two boundary triangles share, and nodes whose
/// triangles do not make one fan.
int num_pinches(const core::TetraMesh &mesh);

/// Separate closed surfaces that bound the mesh: 1 for a body without cavities.
int num_shells(const core::TetraMesh &mesh);

/// Gives islands to the region around them, removes what the body does not hang together with, and takes away the
/// smaller side of every place where the boundary is no manifold, as far as a few rounds go.
void clean(core::TetraMesh &mesh, const std::vector<LabelPiece> &wanted);

} // namespace livermark::segmentation
