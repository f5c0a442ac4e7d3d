#pragma once

#include <filesystem>

#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// Reads a label image: NIfTI (.nii, .nii.gz, .hdr with .img), NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), a DICOM
/// segmentation object (see read_dicom_segmentation()), or a folder with one DICOM series (ITK, which turns NIfTI's RAS
/// into LPS). Values within a thousandth of whole numbers are whole. Readers of others run in a process of their own,
/// which may fail on a damaged file.
/// @return also the names of segments, and remarks on what the file leaves in doubt
/// @throws support::InputError with the file, what is wrong and a remedy: no such format, not three-dimensional,
/// several
///         values per voxel, values that are no labels, sheared axes, absurd spacing, more in the header than in the
///         file, damaged data
LabelImage read_label_image(const std::filesystem::path &file);

/// Writes a label image in the format that the name asks for: .nii, .nii.gz, .nrrd or .mha.
/// @throws support::InputError if the name asks for another one, or nothing can be put there
void write_label_image(const std::filesystem::path &file, const LabelImage &image);

/// Writes a scan in the same way.
void write_scan(const std::filesystem::path &file, const Scan &scan);

} // namespace livermark::segmentation
