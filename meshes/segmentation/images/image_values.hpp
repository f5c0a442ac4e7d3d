#pragma once

#include <filesystem>
#include <itkImage.h>
#include <itkImageIOBase.h>
#include <map>
#include <string>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "meshes/segmentation/images/image_headers.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

/// Contents of image files as ITK reads them, before anything is believed. Internal to segmentation/.
namespace livermark::segmentation {

/// Single precision holds every label exactly, and shows what is none.
using Values = itk::Image<float, 3>;

inline constexpr const char *image_formats =
    "NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), a DICOM segmentation or a folder with one "
    "DICOM series";

/// Angle by which axes may miss a right one: headers with few digits are off by less, a tilted gantry by degrees.
inline constexpr double most_degrees_off = 0.3;

/// Voxels of a file, and what it says of them.
struct ReadValues {
    Values::Pointer values;
    std::map<int, std::string> names;
    std::map<int, core::SegmentCode> codes;
    HeaderGrid header;              ///< what it says of the place of the voxels
    std::string patient_position{}; ///< LabelImage::patient_position
    std::vector<std::string> remarks;
};

/// The sizes of a header must be possible before memory is asked for it.
/// @throws support::InputError if it is not
void check_header(itk::ImageIOBase &io, const std::filesystem::path &file);

/// Whether something else is read in the place of a file: ITK takes axes that are only rounded for sheared, knows
/// endings in lower case alone, and does not read NIfTI-2.
bool needs_a_copy(const std::filesystem::path &file);

/// Reads a file of one image.
/// @param scratch  a folder for what is read in its place; empty if nothing is
/// @throws support::InputError, itk::ExceptionObject
ReadValues read_image_values(const std::filesystem::path &file, const std::filesystem::path &scratch);

/// A text of DICOM, which ends with spaces or a zero where its length would be odd.
std::string without_padding(std::string text);

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
