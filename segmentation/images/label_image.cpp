#include "segmentation/images/label_image.hpp"

namespace livermark::segmentation {

std::size_t num_voxels(const ImageGrid &grid) {
    return static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]) *
           static_cast<std::size_t>(grid.size[2]);
}

double voxel_volume(const ImageGrid &grid) {
    return grid.spacing.prod();
}

core::Vector3 to_world(const ImageGrid &grid, const core::Vector3 &place) {
    return grid.origin + grid.direction * place;
}

} // namespace livermark::segmentation
