#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::studies {

/// The models asked for by name, with what judges them beside them, in the order of the table: the reference, the
/// refined reference, and those of motion where something moves. All if none was asked for.
/// @param with_uncertainty  if not, the refined reference runs only if it was asked for by name
/// @throws support::InputError for a name that there is not, with the nearest one that there is
std::vector<core::Model> choose_models(const std::vector<std::string> &wanted, const models::ModelOptions &options,
                                       bool with_uncertainty);

/// The one that scales loads, of all models.
const core::Model &baseline_of(const std::vector<core::Model> &models);

/// Whether it is a result like others that a model finds no solution: in the large regime, unless it is a reference.
bool may_fail(const std::string &model, core::Regime regime);

/// Finds the solution of a model to a problem, or has it already.
using SolveModel = std::function<core::Solution(const core::Model &, const core::Problem &)>;

/// Lets every model solve a problem and compares it with the reference: with the refined one if that was solved and the
/// other is not good enough, see results::estimate_uncertainty(). A model that finds no solution is part of the result;
/// where the reference finds none, nothing is compared.
/// Of several MPI ranks all call this; the collective models run on all of them and first, so that no failure of
/// another model leaves a rank waiting. The others run on rank 0, which alone compares.
/// @param solve  called for each model that runs on this rank
results::Result evaluate(const core::Problem &problem, const std::vector<core::Model> &models, const SolveModel &solve,
                         results::Provenance provenance);

/// A model that is farther than this from its own linearised solution is not to be compared with linear elasticity.
inline constexpr double fair_nonlinearity = 0.05;

/// The amplitudes at which linear elasticity is a fair reference: a row for each body, load case and non-linear model,
/// its distance from its own linearised solution [%] in a column for each amplitude, and the amplitude up to which all
/// are below fair_nonlinearity.
/// @param results     of problems from at_amplitudes(), those that failed missing
/// @param amplitudes  ascending
results::Layout nonlinearity_by_amplitude(std::span<const results::Result> results, std::span<const double> amplitudes);

} // namespace livermark::studies
