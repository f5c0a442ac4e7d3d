#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/generators/liver_shape.hpp"

namespace livermark::meshes {

/// Place of a liver in the axes of liver_level(), its shape, and its fit there.
struct LiverFit {
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity().eval(); ///< from the body's axes, with a positive determinant
    core::Vector3 offset = core::Vector3::Zero();                ///< [m]
    LiverShape shape;      ///< that the liver has there, at the scale and the place of the one that ships
    double distance = 0.0; ///< rms distance of the body's boundary from the capsule, its normals and the bending [m]
    double next_distance = 0.0; ///< the same in the best of the other orientations, 60 degrees away or more [m]

    core::Vector3 place(const core::Vector3 &point) const { return linear * point + offset; }
    /// Unit normal of a facet there.
    core::Vector3 normal(const core::Vector3 &area_vector) const;

    /// The rotation in the map, from LPS to the body's axes.
    Eigen::Matrix3d from_lps() const;
    /// By how much the body is turned away from LPS [rad].
    double turn() const;

    /// Certainty of this orientation: 1 - distance / next_distance, from 0 to 1.
    double confidence() const;
};

/// Lays the liver that ships over the liver of a mesh, in any position and orientation, and bends it there.
///
/// Centroid and second moments C of the volume are made those of the liver that ships. That leaves a rotation Q:
///   x' = c_0 + C_0^(1/2) Q V C^(-1/2) (x - c)
/// with the principal axes V of the mesh, towards the longer tails, so that nothing depends on how the mesh is turned.
/// Of 1000 rotations (Alexa 2022, Super-Fibonacci spirals, CVPR) those are refined that bring the boundary nearest to
/// the capsule. From the best of each valley the liver that ships is bent (adjusted()), with a Riedel's lobe and
/// without. The fit of the least distance is taken.
/// @param mesh      with its boundary [m]
/// @param from_lps  how it lies, where that is known: the best fit within 60 degrees of that is taken, if there is one
LiverFit fit_liver(const core::TetraMesh &mesh, const std::optional<Eigen::Matrix3d> &from_lps = {});

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
