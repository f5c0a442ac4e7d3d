#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// In the formats of HDF5 1.10 all that describes the data ends in a checksum, so that damage does not come further.
/// These let it.
namespace livermark::fuzz {

/// lookup3 of Bob Jenkins (https://burtleburtle.net/bob/c/lookup3.c, hashlittle), as H5_checksum_lookup3 has it.
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

} // namespace livermark::fuzz
