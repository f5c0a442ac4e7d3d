#pragma once

#include <filesystem>

#include "results/records/needle.hpp"

namespace livermark::results {

/// Writes the "needle files" of results/schema.md as write_result() writes results.
/// @throws support::InputError if the place cannot be written to
void write_needles(const std::filesystem::path &path, const NeedleFile &needles);

/// Reads what write_needles wrote.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
NeedleFile read_needles_file(const std::filesystem::path &path);

} // namespace livermark::results
