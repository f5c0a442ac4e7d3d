#pragma once

#include <filesystem>

#include "core/relaxation.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

/// Reads a Prony series:
///
///     title = "what relaxes"
///     moduli = [0.3, 0.3]   # g_k, parts of the shear modulus of the elastic law that fade; their sum is below 1
///     times = [1.86, 51.3]  # tau_k [s], as many
///     source = "where the numbers come from"
///
/// @throws support::InputError with file, line and remedy
core::PronySeries read_prony_series(const std::filesystem::path &toml_file);

/// Reads the [history] of a load case, see read_load_case().
/// @param table  of the load case
/// @param file   of the load case: a path to a series is relative to its folder
/// @throws support::InputError with file, line and remedy: a series that is not there or makes no sense, times that
///   are not positive, keys that do not go together, a release from elsewhere than the whole load or in the large
///   regime
core::SlowHistory read_history(const toml::table &table, const std::filesystem::path &file);

} // namespace livermark::load_cases
