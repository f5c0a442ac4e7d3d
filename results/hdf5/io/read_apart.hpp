#pragma once

#include <filesystem>
#include <functional>

/// Internal to results/.
namespace livermark::results::hdf5 {

/// Lets a reader try a file in a process of its own. HDF5 1.10 crashes on files whose checksums are right and whose
/// contents are not, and does so again in the same place: after that the file may be read here.
/// @param read  may throw InputError
/// @throws support::InputError of the reader, or one that says how the process ended; FileInUse
void try_apart(const std::filesystem::path &path, const std::function<void()> &read);

/// Reads a file from outside.
template <class Read> auto read_once_tried(const std::filesystem::path &path, const Read &read) {
    try_apart(path, [&] { read(); });
    return read();
}

} // namespace livermark::results::hdf5
