#pragma once

#include <vector>

#include "meshes/segmentation/meshing/label_domain.hpp"

namespace livermark::segmentation {

/// A part of a region that hangs together.
struct LabelPiece {
    int region = 0;
    double volume = 0.0;   ///< [m^3]
    core::Vector3 deepest; ///< a sample that is as far from the border as any [m]
};

/// The pieces of all regions, region by region and the largest first; neighbours are samples side by side.
/// @param smallest  volume below which a piece is noise [m^3]; the largest of each region is there however small
std::vector<LabelPiece> find_pieces(const LabelDomain &domain, double smallest);

/// A place on the border between two labels.
struct BorderPoint {
    core::Vector3 place; ///< [m]
    int from = 0;        ///< labels on its two sides
    int to = 0;
};

/// Points where rays from the deepest place of each piece leave it: with some of these points to start from a mesher
/// cannot overlook the piece. No two are closer than goes with the size of the tetrahedra and the piece.
/// @param edge  of the tetrahedra that are wanted [m]
std::vector<BorderPoint> border_points(const LabelDomain &domain, const std::vector<LabelPiece> &pieces, double edge);

/// The tetrahedra of each part of a region that hangs together across faces, largest part first.
std::vector<std::vector<int>> mesh_pieces(const core::TetraMesh &mesh);

/// Number of pieces that the regions have in the mesh beyond or below those wanted, all in all.
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
