#pragma once

#include <functional>

#include "core/mesh/refinement.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::models {

/// Limits of a solution on ever finer meshes.
struct Refinement {
    double goal;      ///< of each number of core::ObservedError, where it stops
    int finest_level; ///< that it does not go beyond; at least 2
};

/// Solves on the mesh, and on meshes that are finer and finer, at least three, until all errors are known to be below
/// the goal; see core::extrapolated(). A level without a solution ends it: what comes before is the solution then. If
/// those are fewer than three, their error is observed where three levels have come to on the way to the whole load,
/// see core::observed_error_on_path(), and unknown if they have come nowhere.
/// @param problem  at the nodes of whose mesh solutions are given
/// @param solve  the solution on the mesh that is refined so often, the nodes of the mesh first; asked for in ascending
///   order
/// @return with the seconds of all levels
core::Solution solve_refined(const core::Problem &problem, const Refinement &refinement,
                             const std::function<core::Solution(int level)> &solve);

using RefineProblem = std::function<core::BisectedProblem(const core::Problem &)>;

/// The same on meshes that are refined where most of the error is.
/// @param refine  such as core::refine_at_rims_and_tools
/// @param solve   the solution at the nodes of the mesh that it gets, those of the coarsest first
core::Solution solve_locally_refined(const core::Problem &problem, const Refinement &refinement,
                                     const RefineProblem &refine,
                                     const std::function<core::Solution(const core::Problem &)> &solve);

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
