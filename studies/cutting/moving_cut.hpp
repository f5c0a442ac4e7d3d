#pragma once

#include <string>
#include <vector>

#include "results/records/cut.hpp"
#include "studies/cutting/growing_cut.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// Which methods move a body while a blade goes on.
struct CutMotionOptions {
    std::vector<std::string> methods;                      ///< none if there are none; "all" for all
    std::vector<double> budgets{0.001, 0.004, 1.0 / 60.0}; ///< of one core, for a frame [s]
    int frames_per_step = 6;                               ///< of the blade
};

/// Their names, in the order of the table.
/// @throws support::InputError for one that is none, and for budgets or frames that are not above 0
std::vector<std::string> chosen_methods_under_blade(const CutMotionOptions &options);

/// @throws support::InputError if some directions of a node are constrained and others are not, or a place is displaced
void check_loads_of_motion(const core::Problem &problem);

/// How long a body is given to come to rest, before the blade and after it, in frames.
inline constexpr int frames_to_rest = 120;

/// Moves methods under constant loads while a blade goes on: from rest, frames_to_rest frames in which the body comes
/// to its place, then for each stage the cut and frames_per_step frames, then frames_to_rest. Within each budget a
/// method takes one step in a frame with as many iterations as fit, and as many steps as fit of ten iterations and of
/// one: models::all_settings. Methods with a least number of steps take that, or twice that if they diverge, and have
/// one run, with the smallest budget that it fits into, or the largest.
/// @param stages    of grow_cut()
/// @param problems  the loads on each of them, which pass check_loads_of_motion()
/// @return method by method, and budget by budget
std::vector<results::CutMotion> move_under_blade(const CutMotionOptions &options, const std::vector<CutStage> &stages,
                                                 const std::vector<core::Problem> &problems,
                                                 const ProgressReport &report);

} // namespace livermark::studies
