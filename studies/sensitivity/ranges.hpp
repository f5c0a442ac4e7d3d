#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "results/records/sensitivity.hpp"
#include "studies/sensitivity/patient.hpp"

namespace livermark::studies {

/// What a file of ranges says.
struct Ranges {
    std::vector<results::UncertainParameter> parameters; ///< tool_offset as tool_offset_1 and tool_offset_2
    std::optional<double> displacement_noise;            ///< of a measured displacement [m]
};

/// The file that ships, below the root.
inline constexpr const char *ranges_that_ship = "results/parameter_ranges.toml";

/// Reads tables [young_modulus], [poisson_ratio], [tumour_contrast], [density], [held_share], [support_stiffness] and
/// [tool_offset], each with from, to, source and maybe scale = "logarithmic", and [measurement] with displacement and
/// source. What is left out does not vary.
/// @throws support::InputError for unknown keys, a range that is empty or that the parameter cannot have, a missing
///   source, or a file without a range
Ranges read_ranges(const std::filesystem::path &file);

/// The parameters that act on a problem, and why the others do not.
struct ActingParameters {
    std::vector<results::UncertainParameter> parameters;
    std::vector<std::string> notes; ///< a sentence for each that does not act
};

/// Tumours need a body that has some, density an acceleration, the support facets that hold, and the place of the tool
/// one round tool.
ActingParameters acting_on(const core::Problem &problem, const Ranges &ranges);

/// @param values  (P) SI
Patient patient_of(const std::vector<results::UncertainParameter> &parameters, const std::vector<double> &values);

} // namespace livermark::studies
