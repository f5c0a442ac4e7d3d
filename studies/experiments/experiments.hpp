#pragma once

#include <optional>
#include <string>
#include <vector>

#include "load_cases/experiments/experiment.hpp"
#include "results/records/experiment.hpp"
#include "studies/experiments/ring_downs.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// What `livermark experiment` was asked for.
struct ExperimentOptions {
    std::vector<std::string> names;    ///< of public experiments, or paths of .toml files; all whose data are there
    std::vector<std::string> models;   ///< beside the reference; all that take part if there are none
    bool with_methods = false;         ///< also interactive methods, where no model is named
    std::optional<double> edge_length; ///< in place of that of the experiment [m]
    bool refines_reference = true;     ///< solves the reference also with each tetrahedron cut into eight
    bool rings_down = true;            ///< also lets go where that was measured
    DampingForces damping = DampingForces::rayleigh;
    std::string output; ///< folder for <name>.h5
};

struct ExperimentResults {
    std::vector<results::ExperimentResult> of_experiment;
    std::vector<std::string> files; ///< of each
    std::vector<std::string> notes; ///< what a user should know, a sentence each
};

/// Puts models beside one experiment.
/// @throws support::InputError for a model that is not known, or an edge length of a body that has a mesh of its own
results::ExperimentResult evaluate_experiment(const experiments::Experiment &experiment,
                                              const ExperimentOptions &options, const std::string &command_line,
                                              const ProgressReport &report);

/// Reads experiments, puts models beside them, and writes <output>/<name>.h5.
/// @throws support::InputError for bad input, where data are not there, and where a file cannot be written
ExperimentResults run_experiments(const ExperimentOptions &options, const std::string &command_line,
                                  const ProgressReport &report);

} // namespace livermark::studies
