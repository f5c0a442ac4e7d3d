#pragma once

#include <filesystem>
#include <vector>

#include "results/hdf5_io.hpp"
#include "results/result.hpp"

/// What every file that Livermark writes has in common. Internal to results/.
namespace livermark::results::hdf5 {

/// The attributes of the root that say where a file comes from.
void write_provenance(OutputFile &file, const Provenance &provenance);

/// Puts a file in its place when it is whole: under a temporary name in the same directory, then renamed. An earlier
/// file stays as it was if that fails.
/// @param path  in a directory that exists
/// @throws core::InputError if the place cannot be written to
void write_whole(const std::filesystem::path &path, const std::vector<char> &bytes);

} // namespace livermark::results::hdf5
