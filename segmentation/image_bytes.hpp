#pragma once

#include <filesystem>

namespace livermark::segmentation {

/// NIfTI and MetaImage files that were cut off come out of ITK with the rest as zeros: a liver without its top. Does
/// the file hold as many bytes of voxels as its header says? Formats of which ITK takes care itself pass.
/// @param data_bytes  of the voxels
/// @throws support::InputError
void check_all_there(const std::filesystem::path &file, double data_bytes);

} // namespace livermark::segmentation
