#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// Where the solution of a model to a problem is stored: <folder>/<body>/<load case>.<model>.<fingerprint()>.h5.
std::filesystem::path reference_path(const std::filesystem::path &folder, const core::Problem &problem,
                                     const std::string &model);

/// Writes a solution with its fingerprint, the model's name and where it comes from; of a motion the probes and not the
/// frames.
/// @throws support::InputError if the place cannot be written to
void write_reference(const std::filesystem::path &path, const core::Solution &solution, const core::Problem &problem,
                     const std::string &model, const Provenance &provenance);

/// Reads what write_reference wrote. The solver of the solution says that it was stored, since when and of which
/// commit.
/// @return nothing if there is no such file, or if it is of something else
/// @throws support::InputError if it is damaged
std::optional<core::Solution> read_reference(const std::filesystem::path &path, const core::Problem &problem,
                                             const std::string &model);

} // namespace livermark::results
