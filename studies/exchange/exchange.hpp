#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "results/records/arena.hpp"
#include "results/records/result.hpp"
#include "studies/exchange/formats/export_format.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

/// The problem of a load case on a body, for a model outside of this suite.
struct ExportOptions {
    std::string body;
    std::string load_case;
    std::string output = ".";           ///< folder for <body>/<load case>.inp and the like
    std::vector<std::string> formats{}; ///< of exchange::all_formats(); those that need not be named if there are none
    exchange::ExportChoices choices{};
};

/// The files that were written, and what a user should know of the input.
struct ExportedProblem {
    std::vector<std::filesystem::path> files;
    std::vector<std::string> notes;
};

/// Part of a problem that no nodal forces can say.
struct FurtherPart {
    std::string noun, group; ///< such as "a ball that touches"; of the .problem.h5
    exchange::FurtherKind kind = exchange::FurtherKind::other;
};

std::vector<FurtherPart> further_parts(const core::Problem &problem);

/// Writes <output>/<body>/<load case>.problem.h5, a result file without solutions, and a file for each of the formats.
/// Under a moving tool it is <load case>.scene.h5: mesh, materials, and where the tool takes its nodes; and beside it,
/// of the same numbers, <load case>.feb for FEBio and <load case>.sofa.py for SOFA, by the Python package.
/// @param command_line  kept in the result file
/// @throws support::InputError for bad input, where a file cannot be written, and under a moving tool without h5py
ExportedProblem export_problem(const ExportOptions &options, const std::string &command_line);

/// The node displacements of a model outside of this suite, and what they are compared with.
struct ScoreOptions {
    std::string body;
    std::string load_case;
    std::string solution; ///< a file of read_outside_solution()
    std::string name = "mine";
    std::vector<std::string> models{models::baseline_name()};
    std::string output; ///< folder for <body>/<load case>.<name>.h5
    bool reference_on_mesh = false;
    bool solve_reference = false; ///< also where a solution is stored
    /// Unit of the displacements: "m", "cm", "mm" or metres; if it is empty they are taken to be in metres, and refused
    /// where they are so large that they are probably not.
    std::string unit{};
};

/// The comparison, the file that it is in, and what a user should know of the input.
struct Score {
    results::Result result;
    std::filesystem::path file;
    std::vector<std::string> notes;
};

/// Why a model cannot have a name, which stands in paths of the result file; empty if it can.
std::string fault_of_name(const std::string &name);

/// A sentence if the displacements of a model point against those of the reference: its sign is probably wrong.
std::vector<std::string> doubts_about_sign(const results::Result &result, const std::string &name);

/// Compares displacements at the nodes of the mesh with the reference, and writes nothing.
/// @param problem       with its loads scaled
/// @param displacement  shape (N) [m]
/// @param options       body and load case are those of the problem; the solution is a word for where it comes from
/// @param command_line  kept in the result
/// @throws support::InputError if the load case depends on time, if a model has that name already, if none can have it,
/// and for positions in place of displacements
results::Result score_displacement(const core::Problem &problem, const std::vector<core::Vector3> &displacement,
                                   const ScoreOptions &options, const std::string &command_line,
                                   const ProgressReport &report);

/// Compares displacements that were found elsewhere with the reference, and writes a result file.
/// @param command_line  kept in the file
/// @throws support::InputError for bad input, and where the file cannot be written
Score score(const ScoreOptions &options, const std::string &command_line, const ProgressReport &report);

/// The comparison, as an arena of one run, its problem, and the file that it is in.
struct MotionScore {
    results::Arena arena;
    core::Problem problem;
    std::filesystem::path file;
    std::vector<std::string> notes;
};

/// Compares a motion that was found elsewhere with the stored reference, or where none is stored with a coarse one of
/// coarse_tool_reference() in <output>/<body>/<load case>.coarse_reference.h5, which the notes say; and writes
/// <output>/<body>/<load case>.<name>.h5, an arena file. What it cost is what its maker says.
/// @throws support::InputError for bad input, and where the files cannot be written
MotionScore score_motion(const ScoreOptions &options, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
