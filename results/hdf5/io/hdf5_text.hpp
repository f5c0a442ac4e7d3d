#pragma once

#include <span>
#include <string>
#include <vector>

#include "results/hdf5/io/hdf5_io.hpp"

/// Texts in HDF5 files: characters of fixed length, padded with null characters. Variable-length texts are kept in a
/// global heap that has no checksum, and HDF5 1.10.8 copies beyond the end of a damaged one (H5HG_read).
/// Internal to results/.
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

/// What padded() was made of.
std::vector<std::string> unpadded(const std::string &characters, std::size_t length);

/// Why a type is not that of texts of fixed length, no longer than the longest; empty if it is.
std::string fault_of_text_type(hid_t type);

} // namespace livermark::results::hdf5
