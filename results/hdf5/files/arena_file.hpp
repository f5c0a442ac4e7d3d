#pragma once

#include <filesystem>

#include "results/records/arena.hpp"

namespace livermark::results {

/// Writes the "arena files" of results/schema.md as write_result() writes results.
/// @throws support::InputError if the place cannot be written to
void write_arena(const std::filesystem::path &path, const Arena &arena);

/// Reads what write_arena wrote.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
Arena read_arena(const std::filesystem::path &path);

} // namespace livermark::results
