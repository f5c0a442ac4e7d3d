#pragma once

#include <string>
#include <vector>

#include "results/records/needle.hpp"
#include "studies/arena/arena.hpp"

namespace livermark::studies {

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
