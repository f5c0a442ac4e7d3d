#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "results/result.hpp"

namespace livermark::results {

/// The error bands of all models on all problems.
struct ErrorBands {
    std::map<std::array<std::string, 3>, ErrorBand> bands; ///< key: body, load case, model

    /// @return nothing if no band is set for this model on this problem
    std::optional<ErrorBand> find(const std::string &body, const std::string &load_case,
                                  const std::string &model) const;
};

/// Reads a TOML file of tables [<body>.<load case>.<model>], each with
///   relative_l2 = <number, >= 0>
///   margin      = <number, > 0>
///   origin      = "<where the number comes from>"
/// @throws core::InputError that names file and line for what is not TOML, and for keys or values that are not as above
ErrorBands read_error_bands(const std::filesystem::path &path);

} // namespace livermark::results
