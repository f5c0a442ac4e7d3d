#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/hdf5_checksums.hpp"
#include "support/random_numbers.hpp"

/// Damage as it is in files of other people, and worse. The same number gives the same file everywhere.
namespace livermark::fuzz {

/// What any format may have suffered: bits and bytes that are wrong, integers that are absurd, parts that are missing,
/// doubled, swapped or overwritten, an end that is not there, bytes behind the end.
void damage_bytes(std::string &bytes, support::RandomNumbers &random);

/// What lines of words and numbers may have suffered: numbers that are absurd, words in the place of others, lines that
/// are missing, doubled, swapped or without an end.
/// @param length  of the text, which may be only the header of a file
void damage_text(std::string &bytes, std::size_t length, support::RandomNumbers &random);

/// Absurd values in the fields of a NIfTI-1 header.
void damage_nifti_header(std::string &bytes, support::RandomNumbers &random);

/// Absurd values and lengths in data elements of DICOM, elements that are missing, doubled or swapped.
void damage_elements(std::string &bytes, support::RandomNumbers &random);

/// Other bytes in blocks of an HDF5 file, and addresses of one in another, with the checksums made right again; or
/// other bytes in the data, which have none.
/// @param blocks  of the file before
void damage_hdf5(std::string &bytes, const std::vector<ChecksummedBlock> &blocks, support::RandomNumbers &random);

/// A seed with one to three faults of those that fit its kind.
/// @param kind    as of kinds_of_seeds(), or hdf5
/// @param blocks  of HDF5
std::string damaged(std::string_view kind, std::string bytes, std::uint64_t number,
                    const std::vector<ChecksummedBlock> &blocks = {});

} // namespace livermark::fuzz
