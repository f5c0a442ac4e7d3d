#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace livermark::support {

/// A text in lower case, in which endings of file names are compared: Windows writes some in upper case.
inline std::string lower_case(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

/// The extension of a file name in lower case, such as ".msh".
inline std::string file_ending(const std::filesystem::path &file) {
    return lower_case(file.extension().string());
}

} // namespace livermark::support
