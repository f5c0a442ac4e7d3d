#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

/// The smallest files of other people's formats that are read, made here: where mutations start.
namespace livermark::fuzz {

/// A file, and what has to lie beside it.
struct SeedFile {
    std::string name;                            ///< such as surface.stl
    std::string bytes;                           ///< what is changed
    std::map<std::string, std::string> beside{}; ///< by name, as they are
    /// Whether the reader is given the folder in which all lie, as with a DICOM series, and not the file.
    bool is_folder = false;
    bool is_gzipped = false; ///< whether the file is these bytes, compressed
};

/// In the format of gzip (RFC 1952).
std::string gzipped(const std::string &bytes);

/// The kinds that there are seeds of: stl, ply, obj_off, nifti, nrrd, metaimage, dicom.
std::vector<std::string> kinds_of_seeds();

/// Each is read as it is.
/// @param kind  one of these
std::vector<SeedFile> seeds_of(std::string_view kind);

/// Data elements of DICOM in explicit VR, little endian (PS3.5 7.1.2), written as bytes: a number, an element, an item
/// of a sequence.
inline std::string little_endian(std::uint64_t value, int bytes) {
    std::string text;
    for (int b = 0; b < bytes; ++b)
        text += static_cast<char>(value >> (8 * b) & 0xff);
    return text;
}

/// @param tag  group and element, such as 0x00280010
inline std::string element(std::uint32_t tag, const std::string &vr, std::string value) {
    if (value.size() % 2 != 0)
        value += vr == "UI" || vr == "OB" ? '\0' : ' ';
    const bool is_long = vr == "SQ" || vr == "OB";
    return little_endian(tag >> 16, 2) + little_endian(tag & 0xffff, 2) + vr +
           (is_long ? std::string(2, '\0') + little_endian(value.size(), 4) : little_endian(value.size(), 2)) + value;
}

/// An element of unsigned 16 bits.
inline std::string number(std::uint32_t tag, std::uint32_t value) {
    return element(tag, "US", little_endian(value, 2));
}

/// An item of a sequence.
inline std::string item(const std::string &content) {
    return little_endian(0xfffe, 2) + little_endian(0xe000, 2) + little_endian(content.size(), 4) + content;
}

/// The beginning of a file: the preamble, and the group that says how the rest is written.
inline std::string dicom_start(const std::string &sop_class) {
    return std::string(128, '\0') + "DICM" + element(0x00020002, "UI", sop_class) + element(0x00020003, "UI", "1.2.3") +
           element(0x00020010, "UI", "1.2.840.10008.1.2.1");
}

} // namespace livermark::fuzz
