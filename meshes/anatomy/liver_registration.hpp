#pragma once

#include <optional>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/generators/liver/liver_shape.hpp"

namespace livermark::meshes {

/// Where a liver lies in the axes of liver_level(), which shape it has, and how well it fits there.
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

    /// How clearly this orientation is the right one: 1 - distance / next_distance, from 0 to 1.
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

} // namespace livermark::meshes
