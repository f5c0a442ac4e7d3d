#pragma once

#include <cstdint>
#include <vector>

namespace livermark::report {

/// Pixels in rows from the top, each red, green and blue.
struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb; ///< (height, width, 3)
};

/// The bytes of a PNG file, the same for the same picture.
/// @throws std::runtime_error if libpng refuses
std::vector<std::uint8_t> png_bytes(const Picture &picture);

} // namespace livermark::report
