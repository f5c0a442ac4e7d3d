#pragma once

#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

struct LabelFields; // mesh_operations.hpp

/// Something that a mesh has to reach.
struct QualityCriterion {
    std::string name;   ///< with the unit of its numbers
    double value = 0.0; ///< what the mesh has
    double bound = 0.0; ///< what it must have
    bool is_met = false;
    std::string remedy;     ///< what to do where it is not met
    bool is_advice = false; ///< a mesh that misses it has the right numbers all the same
};

/// Distances of a mesh's surface (its nodes, and the middles of its facets) from the surface of the voxels [m]. Half a
/// voxel is noise: the mesh is smooth, and the voxels have steps.
struct SurfaceDistance {
    double median = 0.0, percentile_95 = 0.0, worst = 0.0;
};

struct PatientBody {
    /// In the axes of the image, with regions as in the fields, no names and one patch "surface"; or in the world
    /// (LPS), in whole nanometres, with regions named as in the segmentation [m].
    core::TetraMesh mesh;
    std::vector<QualityCriterion> quality_criteria; ///< what this mesh has to reach, and whether it does
    int num_attempts = 0;                           ///< meshes that were made to get here
    SurfaceDistance surface_from_voxels{};          ///< of a mesh in the world
};

/// A conforming tetrahedral mesh of several regions that follows the fields (CGAL's Mesh_3 on their level sets), whose
/// regions have the volumes that the fields ask for, and which is then improved until its shape is fit for springs and
/// finite elements. Deterministic. Where a quality criterion is missed other settings are tried; the best mesh comes
/// back with its quality criteria, met or not:
///   (those marked * are advice, see QualityCriterion)
///   smallest quality 6 sqrt(2) V / l_rms^3   at least 0.15 * (down to 0.02)
///   shortest edge                            at least 0.25 of the mean *
///   volume of each region                    within 1 % of that wanted
///   every region is there, in as many pieces as in the fields (without those of less than a few tetrahedra)
///   one closed surface that is a manifold
///   no stairs: 95th percentile of the angle between neighbouring boundary facets at most 40 degrees *
///   tetrahedra                               within 10 % of the target *
/// @param target_tetrahedra  how many, about
/// @throws std::runtime_error  if no attempt gave a mesh at all
PatientBody mesh_labels(const LabelFields &fields, int target_tetrahedra);

/// Whether all are met that are no advice.
bool all_met(const std::vector<QualityCriterion> &quality_criteria);

/// Edge of a regular tetrahedron of which that many fill a volume [m].
double edge_for(double volume, int num_tetrahedra);

/// The mesh of a segmentation where the patient lies in the scanner, so that results can be laid over the image.
PatientBody patient_body(const Segmentation &segmentation, int target_tetrahedra);

/// @param mesh  in the world
SurfaceDistance distance_from_voxels(const core::TetraMesh &mesh, const Segmentation &segmentation);

/// A line with all three, as meshes::to_text() makes lines.
std::string to_text(const SurfaceDistance &distance);

/// Material that a region has until somebody gives it another, and where it comes from.
struct DefaultMaterial {
    core::Material material;
    std::string source;
};

/// The material of a region by the role that its name has.
DefaultMaterial default_material(const std::string &region);

/// The body file that goes with it: assumed materials with their sources, and under [image] where the body comes from,
/// what was left out or filled, and the figures of the mesh.
/// @param mesh_file  name of the mesh, in the same folder
/// @param command    that makes both again
std::string body_toml(const PatientBody &body, const Segmentation &segmentation, const std::string &image,
                      const std::string &mesh_file, const std::string &command);

} // namespace livermark::segmentation
