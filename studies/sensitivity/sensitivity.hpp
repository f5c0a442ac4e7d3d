#pragma once

#include <string>
#include <vector>

#include "studies/progress.hpp"

/// Samples of patients, solved here. Points, statistics, indices, files and tables are those of
/// python/livermark/studies/sensitivity/, which is asked for them.
namespace livermark::studies {

/// The options of `livermark sensitivity`.
struct SensitivityOptions {
    std::string body;
    std::vector<std::string> load_cases{"palpation", "retraction"};  ///< of the small regime
    std::string model = "fem_p2p1";                                  ///< that solves the samples
    std::vector<std::string> compared{"nodal_neo_hookean", "lloyd"}; ///< models in the budget, the first one judged
    int num_samples = 128;
    std::string ranges;             ///< file; the one that ships if empty
    bool reference_on_mesh = false; ///< compares with the reference on the mesh, whose own error stays unknown
    bool without_law = false;       ///< does not solve the large load case with two laws
    std::string output;             ///< folder for <body>/sensitivity.<load case>.h5
};

struct SensitivityResults {
    std::vector<std::string> files; ///< of each load case
    std::vector<std::string> notes; ///< what a user should know, a sentence each
    std::string folder;             ///< of the files
};

/// Solves a body under each load case for quasi-random patients, and for the one of the files with several models, and
/// estimates what the outputs depend on. A file of the same body, load case, model and ranges is gone on with.
/// @throws support::InputError for bad input, a load case of the large regime or one that moves, too few samples, and
///   where OpenTURNS is missing
SensitivityResults study_sensitivity(const SensitivityOptions &options, const std::string &command_line,
                                     const ProgressReport &report);

/// Tables and sentences of such files, or all of them as JSON in SI units.
/// @param format  "text", "markdown" or "json"
std::string shown_sensitivities(const std::vector<std::string> &files, const std::string &format);

} // namespace livermark::studies
