#pragma once

#include "segmentation/images/label_pieces.hpp"
#include "segmentation/meshing/mesh_labels.hpp"

namespace livermark::segmentation {

/// 95th percentile of the angle between the normals of boundary triangles that share an edge [degrees].
double turn_angle(const core::TetraMesh &mesh);

/// The quality criteria of a mesh whose boundary is there.
/// @param wanted  (R) volumes [m^3]
std::vector<QualityCriterion> measure_quality_criteria(const core::TetraMesh &mesh, const std::vector<double> &wanted,
                                                       const std::vector<LabelPiece> &pieces, int target_tetrahedra);

/// How far a mesh is from its quality criteria: the shares by which they are missed, added up; 0 if all are met.
double total_miss(const std::vector<QualityCriterion> &quality_criteria);

} // namespace livermark::segmentation
