#pragma once

#include <filesystem>
#include <string>

namespace livermark::segmentation {

/// A piece of a header without spaces and ends of lines around it.
std::string trimmed(const std::string &text);

/// NIfTI and MetaImage files that were cut off come out of ITK with the rest as zeros: a liver without its top. Does
/// the file hold as many bytes of voxels as its header says? Formats of which ITK takes care itself pass.
/// A pattern of names that printf cannot be given is refused as well.
/// @param data_bytes  of the voxels
/// @throws support::InputError
void check_all_there(const std::filesystem::path &file, double num_voxels, double data_bytes);

/// Are the voxels of a NIfTI header in two files (.hdr, .img) there?
/// @throws support::InputError
void check_voxels_beside(const std::filesystem::path &file);

/// Headers of NRRD and MetaImage may name files of voxels: devices and pipes among them never end. Nor, nearly, does
/// MetaIO with absurdly many dimensions.
/// @throws support::InputError for what is no plain file or not there, and for a number of dimensions that cannot be
void check_text_of_header(const std::filesystem::path &file);

/// The same for the pixels of a DICOM file, of which GDCM makes up what is not there.
/// @param data_bytes  length of the pixel data element
/// @throws support::InputError
void check_dicom_pixels(const std::filesystem::path &file, std::size_t data_bytes);

} // namespace livermark::segmentation
