#pragma once

#include <cstdint>
#include <vector>

#include "meshes/segmentation/images/segmentation.hpp"

/// Morphology of sets of voxels with a ball, and distances in them, whose lengths are metres whatever the spacing.
/// Internal to segmentation/.
namespace livermark::segmentation {

/// A set of voxels of a grid: (num_voxels) 1 inside, 0 outside, the first axis runs fastest.
using VoxelSet = std::vector<std::uint8_t>;

/// The set, and all between its parts that a ball of this radius cannot reach from outside (closing): holes, tunnels
/// and clefts that are narrower than the ball. Beyond the image nothing is inside.
/// @param radius  [m]
VoxelSet closed_by_ball(const ImageGrid &grid, const VoxelSet &set, double radius);

/// The part of a set that balls of this radius inside it cover (opening): what is thinner than the ball is gone.
/// @param radius  [m]
VoxelSet opened_by_ball(const ImageGrid &grid, const VoxelSet &set, double radius);

/// Distance of each voxel of a set to the nearest one outside of it, centre to centre; beyond the image nothing is
/// inside.
/// @return (num_voxels) [m], 0 outside
std::vector<float> depths_in(const ImageGrid &grid, const VoxelSet &set);

} // namespace livermark::segmentation
