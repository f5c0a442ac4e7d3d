#pragma once

#include <filesystem>

#include "results/records/growing_cut.hpp"

namespace livermark::results {

/// @throws support::InputError if it cannot be written
void write_cut(const std::filesystem::path &path, const CutFile &cut);

/// @throws support::InputError if it is no cut file
CutFile read_cut_file(const std::filesystem::path &path);

} // namespace livermark::results
