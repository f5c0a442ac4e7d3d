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

struct VoxelCommand {
    std::string labels{};                ///< file, or folder of a DICOM series
    std::vector<int> liver{}, tumours{}; ///< labels
    std::vector<std::string> roles{};    ///< NAME=ROLE
    std::string output{};                ///< the .json file
};

/// Writes the voxels around a body that was made of a label image by this choice, which may end 10 mm beside it. JSON:
/// size (along each axis of the image), origin (centre of the first voxel in the world [m]), steps (3, from voxel to
/// voxel along each axis [m]), parts (names of what a voxel may be), and runs: index of a part and how many voxels in
/// a row are of it, in turns, with the first axis fastest.
/// @return the exit status
/// @throws support::InputError, also if there is too much of it for a browser
int write_voxels(const VoxelCommand &command);

} // namespace livermark::segmentation
