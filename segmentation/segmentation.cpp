#include "segmentation/segmentation.hpp"

namespace livermark::segmentation {

std::vector<double> region_volumes(const Segmentation &segmentation) {
    std::vector<double> volumes(segmentation.region_names.size(), 0.0);
    for (const auto region : segmentation.region)
        if (region != 0)
            volumes[region - 1] += voxel_volume(segmentation.grid);
    return volumes;
}

} // namespace livermark::segmentation
