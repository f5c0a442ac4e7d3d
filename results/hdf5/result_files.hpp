#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "results/records/result.hpp"

namespace livermark::results {

/// Every .h5 file below a folder, whatever is in it, by name.
/// @throws support::InputError if the folder cannot be listed
std::vector<std::filesystem::path> hdf5_files_below(const std::filesystem::path &folder);

/// Reads result files, and what is below folders, by name. In folders, files that other commands leave there and that
/// have no models are left out, and what cannot be read is passed over with a line on standard error.
/// @throws support::InputError if a folder cannot be listed, a file that is named cannot be read, or nothing is there
std::vector<Result> read_results(std::span<const std::filesystem::path> paths);

/// Whether a file says that it contains what the page of `livermark view` shows: solutions of models, or models beside
/// an experiment. Reading it may still find a fault.
/// @throws FileInUse if another program has it open to write, so that nobody can say
bool is_shown_on_page(const std::filesystem::path &path);

} // namespace livermark::results
