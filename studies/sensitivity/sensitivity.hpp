#pragma once

#include <string>
#include <vector>

#include "results/records/sensitivity.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// What `livermark sensitivity` was asked for.
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

/// The fewest samples from which indices of so many parameters are estimated.
int least_samples(std::size_t num_parameters);

struct SensitivityResults {
    std::vector<results::Sensitivity> of_load_case;
    std::vector<std::string> notes; ///< what a user should know, a sentence each
    std::string folder;             ///< of the files
};

/// Solves a body under each load case for quasi-random patients, and for the one of the files with several models, and
/// estimates what the outputs depend on. A file of the same body, load case, model and ranges is gone on with.
/// @throws support::InputError for bad input, a load case of the large regime or one that moves, too few samples, and
///   where OpenTURNS is missing
SensitivityResults study_sensitivity(const SensitivityOptions &options, const std::string &command_line,
                                     const ProgressReport &report);

/// In one sentence, whether the error of the first compared model is large or small beside not knowing the patient; of
/// the output of that number.
std::string verdict(const results::Sensitivity &sensitivity, std::size_t output);

/// All as JSON, SI units; what is not a number is left out.
std::string to_json(const std::vector<results::Sensitivity> &of_load_case);

} // namespace livermark::studies
