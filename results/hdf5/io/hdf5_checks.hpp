#pragma once

#include <filesystem>
#include <string>

#include "results/hdf5/io/hdf5_io.hpp"

/// What a file from outside has to pass before HDF5 is asked for its content: HDF5 1.10.8 believes too much of what a
/// damaged file says of itself. Internal to results/.
namespace livermark::results::hdf5 {

/// Whether the file begins as OutputFile begins it. Older formats of HDF5 have no checksums, and damage of theirs is
/// only found when HDF5 has run into it.
bool has_checksums(const std::filesystem::path &path);

/// @throws FileInUse if another program has the file open to write
void check_not_in_use(const std::filesystem::path &path);

/// Opens all groups and datasets and looks at all links of a file, as h5py does before it reads one, so that what no
/// other reader opens is refused here too. Beside a file that is damaged this may crash.
/// @throws support::InputError
void check_all_parts(const std::filesystem::path &path);

/// Why the numbers of a dataset are not in the file itself: they are in files beside it, or in datasets of other files;
/// empty if they are. Opens none of these.
std::string fault_of_place(hid_t dataset);

/// Why a dataset is none that OutputFile writes: filtered in another way, in chunks or of a size
/// that what is in the file cannot come to; empty if it may be read.
std::string fault_of_storage(hid_t dataset);

} // namespace livermark::results::hdf5
