#pragma once

#include <string>

#include "core/problem.hpp"

namespace livermark::results {

/// Sixteen digits that stand for all that a solution depends on beside the model: mesh, materials, conditions, loads,
/// path, release, and the names and the definition that it is kept with. Every bit counts. It is the same after a
/// result file was written and read.
std::string problem_key(const core::Problem &problem);

/// Sixteen digits that stand for all that a solution depends on: model, mesh, materials, conditions, path, release.
/// Numbers count with nine digits, so that machines that round differently agree.
std::string fingerprint(const core::Problem &problem, const std::string &model);

} // namespace livermark::results
