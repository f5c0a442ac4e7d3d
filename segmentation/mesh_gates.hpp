#pragma once

#include "segmentation/label_pieces.hpp"
#include "segmentation/mesh_labels.hpp"

namespace livermark::segmentation {

/// 95th percentile of the angle between the normals of boundary triangles that share an edge [degrees].
double turn_angle(const core::TetraMesh &mesh);

/// The gates of a mesh whose boundary is there.
/// @param wanted  (R) volumes [m^3]
std::vector<Gate> measure_gates(const core::TetraMesh &mesh, const std::vector<double> &wanted,
                                const std::vector<LabelPiece> &pieces, int target_tetrahedra);

/// How far a mesh is from its gates: the shares by which they are missed, added up; 0 if all are met.
double total_miss(const std::vector<Gate> &gates);

} // namespace livermark::segmentation
