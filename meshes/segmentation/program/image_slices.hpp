#pragma once

#include <string>
#include <vector>

/// Slices of a label image, for pictures of the body that was made of it.
namespace livermark::segmentation {

struct SliceCommand {
    std::string labels{};     ///< file, or folder of a DICOM series
    std::vector<double> at{}; ///< a place in the world that the planes go through [m]
    std::string output{};     ///< the .json file
};

/// Writes the three planes of voxels through a place, across each axis of the image, or the outermost ones if it is
/// outside. JSON: planes, each with size (pixels to the right and up), origin, right and up (place of the first pixel
/// and steps between pixels, in the world [m]) and label (up to down the rows, right fastest).
/// @return the exit status
/// @throws support::InputError
int write_slices(const SliceCommand &command);

} // namespace livermark::segmentation
