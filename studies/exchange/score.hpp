#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "models/model_table.hpp"
#include "results/result.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// The node displacements of a model outside of this suite, and what they are compared with.
struct ScoreOptions {
    std::string body;
    std::string load_case;
    std::string solution; ///< a file of read_outside_solution()
    std::string name = "mine";
    std::vector<std::string> models{std::string(models::baseline_model)};
    std::string output; ///< folder for <body>/<load case>.<name>.h5
    bool no_uncertainty = false;
    bool solve_reference = false; ///< also where a solution is stored
};

/// The comparison, the file that it is in, and what a user should know of the input.
struct Score {
    results::Result result;
    std::filesystem::path file;
    std::vector<std::string> notes;
};

/// Compares displacements that were found elsewhere with the reference, and writes a result file.
/// @param command_line  kept in the file
/// @throws support::InputError for bad input, and where the file cannot be written
Score score(const ScoreOptions &options, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
