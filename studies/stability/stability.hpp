#pragma once

#include <array>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/records/stability.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// By how much prediction and observation may differ, relative.
inline constexpr double largest_difference = 0.02;

/// Which bodies, springs and integrators, and how they are damped.
struct StabilityOptions {
    std::vector<std::string> bodies;
    std::string law = "lloyd";       ///< where no model is named
    std::vector<std::string> models; ///< of the suite, whose springs are taken
    std::string load_case;           ///< that gives the constraints; empty: see read_constrained_problems()
    std::vector<std::string> integrators;
    meshes::MaterialOverride material;
    double damping_ratio = 0.05;                          ///< as load_cases/release.toml
    std::array<double, 2> damping_frequencies{1.7, 10.0}; ///< [Hz]
    std::string output;                                   ///< folder for <body>/stability.<law or model>.h5
    bool no_observed = false;
};

/// The longest steps of each body, and what a user should know of the input.
struct StabilityResults {
    std::vector<results::Stability> of_body;
    std::vector<std::string> notes;
};

/// Predicts the longest stable step of each integrator from the largest frequency of the springs, observes it in runs
/// unless told not to, and writes a stability file for each body and model.
/// @param command_line  kept in the files
/// @throws support::InputError for names that there are not, for a model without springs, and where a file cannot be
/// written
StabilityResults find_stability(const StabilityOptions &options, const std::string &command_line,
                                const ProgressReport &report);

/// Whether all that was observed differs from what was predicted by no more than largest_difference.
bool is_as_predicted(const results::Stability &stability);

} // namespace livermark::studies
