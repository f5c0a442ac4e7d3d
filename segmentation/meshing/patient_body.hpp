#pragma once

#include <string>
#include <vector>

#include "segmentation/images/segmentation.hpp"
#include "segmentation/meshing/mesh_labels.hpp"

namespace livermark::segmentation {

/// Edge of a regular tetrahedron of which that many fill a volume [m].
double edge_for(double volume, int num_tetrahedra);

struct PatientBody {
    core::TetraMesh mesh; ///< in the world (LPS), whole nanometres, regions named as in the segmentation
    std::vector<QualityCriterion> quality_criteria; ///< what the mesh has to reach, and whether it does
    int num_attempts = 0;
};

/// The mesh of a segmentation where the patient lies in the scanner, so that results can be laid over the image.
PatientBody patient_body(const Segmentation &segmentation, int target_tetrahedra);

/// The body file that goes with it: assumed materials with their sources, and under [image] where the body comes from,
/// what was left out or filled, and the figures of the mesh.
/// @param mesh_file  name of the mesh, in the same folder
/// @param command    that makes both again
std::string body_toml(const PatientBody &body, const Segmentation &segmentation, const std::string &image,
                      const std::string &mesh_file, const std::string &command);

} // namespace livermark::segmentation
