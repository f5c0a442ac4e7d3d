#pragma once

#include <filesystem>

#include "meshes/segmentation/images/label_image.hpp"

namespace livermark::segmentation {

/// Whether a file is DICOM: "DICM" stands behind 128 bytes.
bool is_dicom_file(const std::filesystem::path &file);

/// Whether it is a segmentation object (SOP classes Segmentation Storage and Label Map Segmentation Storage).
bool is_dicom_segmentation(const std::filesystem::path &file);

/// Reads a DICOM segmentation object, as 3D Slicer, OHIF and dcmqi write it: each frame is a slice of one segment, in
/// one bit a pixel, or the parts of a pixel that belong to it, of which a half and more counts (PS3.3 A.51); or the
/// frames hold the numbers of segments. Labels are the numbers of the segments. Where segments overlap the smaller one
/// has the voxel: a lesion in a liver. Slices without a frame are empty.
/// @return grid in LPS; not checked yet
/// @throws support::InputError with the file, what is wrong and a remedy: no segmentation object, compressed, frames
/// that
///         are not parallel and evenly spaced, less pixels than frames need
LabelImage read_dicom_segmentation(const std::filesystem::path &file);

} // namespace livermark::segmentation
