#pragma once

#include <filesystem>
#include <itkImage.h>
#include <itkImageIOBase.h>
#include <map>
#include <string>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "meshes/segmentation/images/header_grid.hpp"

/// Contents of image files as ITK reads them, before anything is believed. Internal to segmentation/.
namespace livermark::segmentation {

/// Single precision holds every label exactly, and shows what is none.
using Values = itk::Image<float, 3>;

inline constexpr const char *image_formats =
    "NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), a DICOM segmentation or a folder with one "
    "DICOM series";

/// Headers with few digits are off by less; a tilted gantry by degrees.
inline constexpr double most_degrees_off = 0.3;

/// Options by which a file is read.
struct ReadValues {
    Values::Pointer values;
    std::map<int, std::string> names;
    std::map<int, core::SegmentCode> codes;
    HeaderGrid header; ///< what it says of the place of the voxels
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

} // namespace livermark::segmentation
