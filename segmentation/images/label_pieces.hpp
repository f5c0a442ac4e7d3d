#pragma once

#include <vector>

#include "segmentation/meshing/label_domain.hpp"

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

/// Where rays from the deepest place of each piece leave it: with some of these points to start from a mesher cannot
/// overlook the piece. No two are closer than goes with the size of the tetrahedra and the piece.
/// @param edge  of the tetrahedra that are wanted [m]
std::vector<BorderPoint> border_points(const LabelDomain &domain, const std::vector<LabelPiece> &pieces, double edge);

} // namespace livermark::segmentation
