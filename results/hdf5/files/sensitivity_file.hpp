#pragma once

#include <filesystem>

#include "results/records/sensitivity.hpp"

namespace livermark::results {

/// Writes the "sensitivity files" of results/schema.md as write_result() writes results. While samples are still being
/// solved there are as many points as values, and neither outputs nor a budget.
/// @throws support::InputError if the place cannot be written to
void write_sensitivity(const std::filesystem::path &path, const Sensitivity &sensitivity);

/// Reads what write_sensitivity wrote.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
Sensitivity read_sensitivity(const std::filesystem::path &path);

} // namespace livermark::results
