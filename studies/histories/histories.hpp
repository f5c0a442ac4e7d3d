#pragma once

#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/hdf5/files/history_file.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// What moves, and in which steps.
struct HistoriesOptions {
    std::vector<std::string> bodies;
    std::string law = "lloyd";
    std::string load_case = "release";
    std::string integrator = "runge_kutta_4";
    std::vector<double> time_steps{1.0, 0.5, 0.05, 0.005}; ///< [s]; those of the seed paper
    double duration = 10.0;                                ///< [s]
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/histories.<law>.h5
};

/// Histories of the model of one degree of freedom, then of each body, and what a user should know of the input.
struct HistoriesResults {
    std::vector<results::Histories> of_subject;
    std::vector<std::string> notes;
};

/// Moves the seed paper's model of one degree of freedom, and the springs of bodies that are let go, in steps that may
/// be unstable, and writes a history file for each.
/// @param command_line  kept in the files
/// @throws support::InputError for what cannot be moved, for more than a million steps, and where a file cannot be
/// written
HistoriesResults find_histories(const HistoriesOptions &options, const std::string &command_line,
                                const ProgressReport &report);

} // namespace livermark::studies
