#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/support/random_numbers.hpp"

/// Damage as it is in files of other people, and worse. The same number gives the same file everywhere.
namespace livermark::fuzz {

/// In the formats of HDF5 1.10 all that describes the data ends in a checksum, which would end nearly every trial; so
/// checksums are made right again. This one is lookup3 of Bob Jenkins (https://burtleburtle.net/bob/c/lookup3.c,
/// hashlittle), as H5_checksum_lookup3 has it.
std::uint32_t lookup3(std::string_view bytes, std::uint32_t initial = 0);

/// Bytes [begin, end) of a file, behind which their checksum stands in four bytes.
struct ChecksummedBlock {
    std::size_t begin, end;
};

/// The superblock, object headers, and blocks of heaps, trees and arrays, each of which begins with a signature.
std::vector<ChecksummedBlock> checksummed_blocks(std::string_view file);

/// Makes the checksums right again.
/// @param file  changed inside of blocks, or cut off
void update_checksums(std::string &file, const std::vector<ChecksummedBlock> &blocks);

/// Damage of any format: bits and bytes that are wrong, integers that are absurd, parts that are missing,
/// doubled, swapped or overwritten, an end that is not there, bytes behind the end.
void damage_bytes(std::string &bytes, support::RandomNumbers &random);

/// Damage of lines of words and numbers: numbers that are absurd, words in the place of others, lines that
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
