#pragma once

#include <optional>
#include <string>

#include "results/hdf5/io/hdf5_io.hpp"
#include "results/records/experiment.hpp"

/// The part of experiment files that is about bodies that ring down. Internal to results/.
namespace livermark::results::hdf5 {

/// Writes nothing where nothing was let go.
void write_ring_downs(OutputFile &file, const ExperimentResult &result);

/// Reads them into a result that has its markers; none from files that have none, as older ones.
/// @throws support::InputError for a group that is not complete, or of another shape
void read_ring_downs(const InputFile &file, ExperimentResult &result);

std::optional<core::SolutionStatus> status_of_word(const std::string &word);

} // namespace livermark::results::hdf5
