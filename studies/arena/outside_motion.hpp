#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/records/arena.hpp"
#include "studies/exchange/score.hpp"

/// Moving load cases for programs that are not part of this suite, and what these make of them.
namespace livermark::studies {

/// Writes <output>/<body>/<load case>.scene.h5: mesh, materials, and where the tool takes its nodes; and beside it, of
/// the same numbers, <load case>.feb for FEBio and <load case>.sofa.py for SOFA, by the Python package.
/// @throws support::InputError for bad input, where a file cannot be written, and without h5py, once there is the first
ExportedProblem export_tool_scene(const ExportOptions &options, const std::string &command_line);

/// The comparison, as an arena of one run, and the file that it is in.
struct MotionScore {
    results::Arena arena;
    std::filesystem::path file;
    std::vector<std::string> notes;
};

/// Compares a motion that was found elsewhere with the stored reference, or where none is stored with a coarse one of
/// coarse_tool_reference() in <output>/<body>/<load case>.coarse_reference.h5, which the notes say; and writes
/// <output>/<body>/<load case>.<name>.h5, an arena file. What it cost is what its maker says.
/// @throws support::InputError for bad input, and where the files cannot be written
MotionScore score_motion(const ScoreOptions &options, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
