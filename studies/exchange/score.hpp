#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// The problem of a load case on a body, for a model outside of this suite.
struct ExportOptions {
    std::string body;
    std::string load_case;
    std::string output = "."; ///< folder for <body>/<load case>.inp and the like
    bool quadratic = false;   ///< quadratic tetrahedra (C3D10) in the .inp
};

/// The files that were written, and what a user should know of the input.
struct ExportedProblem {
    std::vector<std::filesystem::path> files;
    std::vector<std::string> notes;
};

/// Writes a problem as HDF5 (a result file without solutions), CalculiX input and VTU.
/// @param command_line  kept in the result file
/// @throws support::InputError for bad input, and where a file cannot be written
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
    /// Of the displacements: "m", "cm", "mm" or metres; if it is empty they are taken to be in metres, and refused
    /// where they are so large that they are probably not.
    std::string unit{};
};

/// Asks in a refusal whether displacements are in metres.
/// @param largest  length of the largest of them [m]
/// @param source   where they come from
/// @throws support::InputError where that is far more than the load case is meant to move the body
void refuse_other_unit(double largest, const core::Problem &problem, const std::string &source);

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

} // namespace livermark::studies
