#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace livermark::support {

/// Says whether a file could be put there, so that long work need not be done for a place that was misspelt.
/// @throws InputError if it cannot
void check_place(const std::filesystem::path &path);

/// Puts a file in its place when it is whole: under a temporary name in the same directory, then renamed. An earlier
/// file stays as it was if that fails. A process that is killed leaves <name>.<its number>.partial, which no reader
/// takes for the file.
/// @param path  in a directory that exists; no device, whose place the file would take
/// @throws InputError if the place cannot be written to
void write_whole(const std::filesystem::path &path, std::span<const char> bytes);

/// Refuses what is no plain file, such as a directory, a named pipe or a device, which would keep a reader waiting.
/// @throws InputError also if it is not there or may not be read
void check_readable(const std::filesystem::path &file);

/// Reads a whole text file, without the byte order mark that some editors put before it.
/// @throws InputError if it cannot be read
std::string read_text(const std::filesystem::path &file);

} // namespace livermark::support
