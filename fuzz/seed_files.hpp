#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

/// What mutations of files of other people's formats start from: the smallest files that are read, made here.
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

} // namespace livermark::fuzz
