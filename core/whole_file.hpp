#pragma once

#include <filesystem>
#include <span>

namespace livermark::core {

/// Puts a file in its place when it is whole: under a temporary name in the same directory, then renamed. An earlier
/// file stays as it was if that fails.
/// @param path  in a directory that exists
/// @throws InputError if the place cannot be written to
void write_whole(const std::filesystem::path &path, std::span<const char> bytes);

} // namespace livermark::core
