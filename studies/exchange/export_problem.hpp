#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

} // namespace livermark::studies
