#pragma once

#include <span>
#include <vector>

#include "core/problem.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::studies {

/// A model that is farther than this from its own linearised solution is not to be compared with linear elasticity.
inline constexpr double fair_nonlinearity = 0.05;

/// The problem at multiples of its load, as load cases "<name>@<amplitude>"; just itself if there are no amplitudes.
/// @param amplitudes  > 0
std::vector<core::Problem> at_amplitudes(const core::Problem &problem, std::span<const double> amplitudes);

/// Where linear elasticity stops being a fair reference: a row for each body, load case and non-linear model, its
/// distance from its own linearised solution [%] in a column for each amplitude, and the amplitude up to which all are
/// below fair_nonlinearity.
/// @param results     of problems from at_amplitudes(), those that failed missing
/// @param amplitudes  ascending
results::Layout nonlinearity_by_amplitude(std::span<const results::Result> results, std::span<const double> amplitudes);

} // namespace livermark::studies
