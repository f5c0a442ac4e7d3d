#pragma once

#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

inline constexpr int most_modes = 1000;

/// Of which bodies, by which models, how many modes.
struct ModesOptions {
    std::vector<std::string> bodies; ///< names or paths; all that ship if there are none
    std::string load_case;           ///< that gives the constraints; empty: see read_constrained_problems()
    std::vector<std::string> models{models::baseline_name(), models::moving_reference(core::Regime::small).on_mesh,
                                    "lloyd"};
    int count = 20; ///< 1 to most_modes
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/modes.<load case>.h5
};

/// Results with modes, one for each body, and what a user should know of the input.
struct ModesResults {
    std::vector<results::Result> of_body;
    std::vector<std::string> notes;
};

/// Finds the lowest modes of bodies constrained as in a load case, and writes a result file for each body.
/// @param command_line  kept in the files
/// @throws support::InputError for names that there are not, and where a file cannot be written
ModesResults find_modes(const ModesOptions &options, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
