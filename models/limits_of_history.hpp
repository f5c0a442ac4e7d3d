#pragma once

#include <functional>

#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::models {

/// The elastic body that a body which relaxes is after all time, under the whole load: a history whose branches fade in
/// no time, so that law and elements are those of the history.
core::Problem relaxed_limit(const core::Problem &problem);

using SolveProblem = std::function<core::Solution(const core::Problem &)>;

/// A slow history on the mesh itself, with the error that meshes are known to make at its two limits: the elastic body
/// at once and after all time, each under the whole load. At each the difference between the mesh and the finer ones,
/// and the observed error of these, add up to the error of the mesh; the larger of both limits is the bar, number by
/// number. The history lies between its limits, but that its error does is an assumption; that of its steps in time is
/// not in it.
/// @param problem      with a slow history
/// @param solve        on the mesh, histories too
/// @param solve_finer  elastic problems on finer meshes, with Solution::observed_error
/// @return the history, with an observed_error if both limits have one
core::Solution solve_between_limits(const core::Problem &problem, const SolveProblem &solve,
                                    const SolveProblem &solve_finer);

} // namespace livermark::models
