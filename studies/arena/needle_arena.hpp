#pragma once

#include <string>
#include <vector>

#include "core/problem.hpp"
#include "results/records/needle.hpp"
#include "studies/arena/arena.hpp"
#include "studies/models/motion/moving_method.hpp"

namespace livermark::studies {

/// A needle and a body on one of the meshes of an arena.
struct NeedleScene {
    const core::Problem &problem;
    const core::Needle &needle;
    models::NeedlePlan plan;
    const results::NeedleArena &arena;                  ///< with what the reference meets
    const std::vector<core::Vector3> &reference_places; ///< (K) displacement of the places at the plan [m]
};

/// The arena of a needle without runs: what the static needle meets at the depths of a plan.
/// @param reference  of the needle on finer meshes
/// @param coarser    the same on the mesh before; null if there is none
results::NeedleArena empty_needle_arena(const core::Needle &needle, const models::NeedlePlan &plan,
                                        const core::Insertion &reference, const core::Insertion *coarser);

/// A method with all budgets and settings on one mesh. What has no choice of its effort moves once, or twice where its
/// steps have to be halved.
std::vector<results::NeedleArenaRun> run_needle_budgets(const models::MovingMethod &method, const NeedleScene &scene,
                                                        const std::vector<double> &budgets);

/// Beside ArenaOptions, what `livermark arena --tool needle` was asked for. Its load case is one of
/// load_cases/needles/, or a path.
struct NeedleArenaOptions {
    std::vector<std::string> needles; ///< names of needles of the load case; all if there are none
    double speed = 0.02;              ///< of the hand [m/s]
    double rest = 0.5;                ///< at the target [s]
    bool reference_on_mesh = false;   ///< judged by the mixed elements on the mesh itself
};

struct NeedleArenaResults {
    std::vector<results::NeedleFile> of_body; ///< each needle with its reference and an arena
    std::vector<std::string> notes;           ///< what a user should know of the input, a sentence each
};

/// Leads the needles of a load case into bodies that methods move, within each budget, on each mesh, compares them with
/// the static needle in the reference at the same depths, and writes <output>/<body>/needle_arena.<load case>.h5.
/// Insertion by centimetres in a second is slow for tissue, so no reference moves.
/// @throws support::InputError for bad input, for a method that was asked for and holds no needle, and where a file
///         cannot be written
NeedleArenaResults run_needle_arena(const ArenaOptions &options, const NeedleArenaOptions &needle_options,
                                    const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
