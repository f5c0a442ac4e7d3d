#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "results/hdf5/io/hdf5_io.hpp"

/// Checks that a file from outside has to pass before HDF5 is asked for its content: HDF5 1.10.8 believes too much of
/// what a damaged file says of itself. Texts are characters of fixed length, padded with null characters, because
/// variable-length texts are kept in a global heap that has no checksum, and HDF5 1.10.8 copies beyond the end of a
/// damaged one (H5HG_read). Internal to results/.
namespace livermark::results::hdf5 {

/// The longest text that is read. The longest that is written is the definition of a load case.
inline constexpr std::size_t longest_text = 1024 * 1024;

/// @param length         bytes, at least 1
/// @param character_set  H5T_CSET_UTF8 or H5T_CSET_ASCII
/// @throws std::runtime_error if HDF5 refuses
Handle text_type(std::size_t length, H5T_cset_t character_set);

/// As many bytes as the longest has, and never none, which HDF5 does not know.
std::size_t common_length(std::span<const std::string> values);

/// All values behind each other, each padded to the length.
std::string padded(std::span<const std::string> values, std::size_t length);

/// Texts that padded() was made of.
std::vector<std::string> unpadded(const std::string &characters, std::size_t length);

/// Why a type is not that of texts of fixed length, no longer than the longest; empty if it is.
std::string fault_of_text_type(hid_t type);

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

/// Lets a reader try a file in a process of its own. HDF5 1.10 crashes on files whose checksums are right and whose
/// contents are not, and does so again in the same place: after that the file may be read here.
/// @param read  may throw InputError
/// @throws support::InputError of the reader, or one that says how the process ended; FileInUse
void try_apart(const std::filesystem::path &path, const std::function<void()> &read);

/// Reads a file from outside.
template <class Read> auto read_once_tried(const std::filesystem::path &path, const Read &read) {
    try_apart(path, [&] { read(); });
    return read();
}

} // namespace livermark::results::hdf5
