#pragma once

#include <filesystem>

#include "results/records/experiment.hpp"

namespace livermark::results {

/// Writes the "experiment files" of results/schema.md as write_result() writes results.
/// @throws support::InputError if the place cannot be written to
void write_experiment(const std::filesystem::path &path, const ExperimentResult &result);

/// Reads what write_experiment wrote.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
ExperimentResult read_experiment(const std::filesystem::path &path);

} // namespace livermark::results
