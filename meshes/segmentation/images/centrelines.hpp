#pragma once

#include <limits>
#include <vector>

#include "core/vessels.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

/// Lines along the vessels of an image. Internal to segmentation/.
namespace livermark::segmentation {

/// Vessels that become lines.
struct CentrelineOptions {
    double least_length = 0.01; ///< of a tree, and of a branch beyond the border of the vessel that it leaves [m]
    double spacing = 0.004;     ///< of the points along a branch, about [m]
    /// Radius beyond which a vessel is left out [m], as one that a mesh has as a region; the tree is in pieces then.
    double largest_radius = std::numeric_limits<double>::infinity();
};

/// The lines along the middles of vessels, from one end of each connected piece to all others: paths that are short and
/// stay deep, the longest first, each to where it meets one before (TEASAR: Sato, Bitter, Bender, Kaufman and Nakajima
/// 2000, Pacific Graphics, 281-289). What lies within two radii of a path belongs to it, so that bumps have no
/// branches; one that reaches less far out of the vessel that it leaves than the radius there is none either. Rings are
/// opened. Lines and radii are means over a radius to each side along a branch; branch points and ends are points of
/// the tree. A radius is the distance to the centre of the nearest voxel outside, which is just beyond the border: up
/// to a tenth more where the radius is two voxels, and a fifth where it is one.
/// @param is_vessel  (num_voxels)
/// @return directed away from an end of each piece: of the two that are farthest apart, the one nearer to where it is
///         thickest; in the world [m], with the usual wall; empty where nothing is a vessel
core::VesselTree centrelines(const ImageGrid &grid, const std::vector<char> &is_vessel,
                             const CentrelineOptions &options);

} // namespace livermark::segmentation
