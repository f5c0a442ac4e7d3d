#pragma once

#include <filesystem>
#include <optional>

#include "results/records/result.hpp"

namespace livermark::results {

/// The result file of a benchmark case that was evaluated before, if evaluating it again would give the same: made by
/// the same command and commit, on the same mesh, materials and loads.
/// @return empty if there is no such file, or if it is damaged: the benchmark case has to be evaluated again
std::optional<Result> resumable_result(const std::filesystem::path &file, const core::Problem &problem,
                                       const Provenance &provenance);

} // namespace livermark::results
