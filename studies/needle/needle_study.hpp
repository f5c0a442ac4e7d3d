#pragma once

#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/records/needle.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// What `livermark needle` was asked for.
struct NeedleOptions {
    std::vector<std::string> bodies;  ///< names or paths
    std::string load_case = "biopsy"; ///< of load_cases/needles/, or a path
    std::vector<std::string> models;  ///< all that run by default and can tell if there are none
    bool reference_on_mesh = false;   ///< judged by the mixed elements on the mesh itself
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/needle.<load case>.h5
};

struct NeedleResults {
    std::vector<results::NeedleFile> of_body;
    std::vector<std::string> notes; ///< what a user should know of the input, a sentence each
};

/// Drives the needles of a load case into bodies, by each model, and writes a file for each body. How a model gives way
/// along the needle is found once, see core::Compliance; all that is the needle's is the same for all models, see
/// insert(). The regime is small: what a model says is linear in the forces.
/// @throws support::InputError for bad input, for a model that cannot tell, and where a file cannot be written
NeedleResults drive_needles(const NeedleOptions &options, const std::string &command_line,
                            const ProgressReport &report);

} // namespace livermark::studies
