#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace livermark::segmentation {

/// What a surface file has to be for a reader that takes its format strictly.
struct PlainSurfaceText {
    std::optional<std::string> text; ///< nothing if the file can be read as it is
    std::size_t num_left_out = 0;    ///< lines and points of an OBJ file, which bound nothing
};

/// Takes away what formats allow, or programs write, and readers stumble over: a byte order mark, keywords of an ASCII
/// STL in capitals, and elements of an OBJ that are no faces.
/// @param ending  of the name, in lower case: .stl, .obj, .ply or .off
PlainSurfaceText plain_surface_text(std::string text, const std::string &ending);

} // namespace livermark::segmentation
