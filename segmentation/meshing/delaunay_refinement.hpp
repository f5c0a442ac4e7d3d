#pragma once

#include "segmentation/images/label_pieces.hpp"
#include "segmentation/meshing/label_domain.hpp"

namespace livermark::segmentation {

struct RefinementSizes {
    double edge = 0.0;            ///< about [m]
    double facet_distance = 0.15; ///< how far a facet's centre may be off the surface, of the edge
    bool against_slivers = true;  ///< perturb nodes and exude slivers in the end
};

/// Delaunay refinement of the domain by CGAL's Mesh_3: nodes lie near the borders of the labels, which triangles
/// approximate. There may be slivers left, and small islands.
/// @param seeds  points of the borders to start from
/// @return points, tetrahedra and regions only
core::TetraMesh refine_delaunay(const LabelDomain &domain, const std::vector<BorderPoint> &seeds,
                                const RefinementSizes &sizes);

} // namespace livermark::segmentation
