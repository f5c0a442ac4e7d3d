#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "results/records/result.hpp"

namespace livermark::results {

/// Whose error a band is about: body, load case, model.
using BandKey = std::array<std::string, 3>;

/// The error bands of all models on all problems.
struct ErrorBands {
    std::map<BandKey, ErrorBand> bands;
    std::map<BandKey, std::string> places{}; ///< "file:line" of each band that was read from a file

    /// @return nothing if no band is set for this model on this problem
    std::optional<ErrorBand> find(const std::string &body, const std::string &load_case,
                                  const std::string &model) const;
};

/// Reads a TOML file of groups. A group is what one run has measured; each of its lines is one model on one body:
///   [[group]]
///   origin = "<where the numbers come from>"
///   margin = <number, > 0; of every band of the group>
///   [group.relative_l2.<body>]
///   <model> = { <load case> = <number, >= 0>, ... }
/// @throws support::InputError that names file and line for what is not TOML, for keys or values that are not as above,
/// and
///         for a band that is there twice
ErrorBands read_error_bands(const std::filesystem::path &path);

/// The text of a file from which read_error_bands() reads the same bands: a group for each origin and margin, in
/// alphabetical order. Empty if there are none.
std::string to_toml(const std::map<BandKey, ErrorBand> &bands);

} // namespace livermark::results
