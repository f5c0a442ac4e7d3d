#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "results/error_bands.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// Half the width of a proposed band. Results repeat to rounding, so this only leaves room for another BLAS or
/// processor.
inline constexpr double proposed_margin = 0.002;

/// The band that a measured error asks for, beside the one that there is.
struct BandProposal {
    BandKey key;
    double relative_l2 = 0.0; ///< as measured
    ErrorBand band; ///< relative_l2 to four decimals +- proposed_margin; its origin is the run: day, commit, reference
    std::optional<ErrorBand> present; ///< none for a new entry

    /// Whether the file has to change: the entry is new, or the error has left its band.
    bool is_due() const { return !present || !present->contains(relative_l2); }
};

struct BandProposals {
    std::vector<BandProposal> proposals;  ///< by key
    std::vector<std::string> passed_over; ///< a sentence for each result or model that no band can come from
};

/// What result files say about the bands of the models in them. References have no band; where a model found no
/// solution, or the reference's uncertainty is not known, so that a run with it may choose another reference, there is
/// none to propose.
/// @param models  only these; all if empty
/// @throws support::InputError if two results are of the same body and load case
BandProposals propose_bands(std::span<const Result> results, std::span<const std::string> models,
                            const ErrorBands &present);

/// The proposed bands as to_toml() takes them.
/// @param all  also those of entries that stay as they are
std::map<BandKey, ErrorBand> proposed_bands(std::span<const BandProposal> proposals, bool all);

} // namespace livermark::results
