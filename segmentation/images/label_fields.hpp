#pragma once

#include <array>
#include <vector>

#include "segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// The regions of a body as smooth fields on a grid of cubes: what the mesher sees of it, whether it was an image or
/// surfaces before.
struct LabelFields {
    std::array<int, 3> size = {0, 0, 0};    ///< samples along each axis
    double spacing = 0.0;                   ///< [m]
    core::Vector3 low = {0.0, 0.0, 0.0};    ///< place of the first sample, in the axes of the image [m]
    std::vector<std::vector<float>> inside; ///< (R) of (samples), the first axis runs fastest: about 1 well inside the
                                            ///< region, 0 well outside it, about 1/2 on its border; 0 on the
                                            ///< border of the grid
    std::vector<double> volume;             ///< (R) that the region has to have in the end [m^3]
};

/// The share of each region in the surroundings of a sample (a Gaussian whose width goes with the voxels), so that the
/// borders are free of the stairs that voxels make.
/// @param spacing  of the samples [m]; no finer than pays for the tetrahedra that are wanted
LabelFields label_fields(const Segmentation &segmentation, double spacing);

} // namespace livermark::segmentation
