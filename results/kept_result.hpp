#pragma once

#include <filesystem>
#include <optional>

#include "results/result.hpp"

namespace livermark::results {

/// The result file of a contest that was held before, if holding it again would give the same: made by the same command
/// and commit, on the same mesh, materials and loads.
/// @return empty if there is no such file, or if it is damaged: the contest has to be held again
std::optional<Result> kept_result(const std::filesystem::path &file, const core::Problem &problem,
                                  const Provenance &provenance);

} // namespace livermark::results
