#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "models/model_table.hpp"
#include "results/error_bands.hpp"
#include "results/result.hpp"

namespace livermark::app {

/// The models asked for by name, with the reference, the refined reference and the baseline beside them, in the order
/// of the table; all if none was asked for.
/// @param with_uncertainty  if not, the refined reference runs only if it was asked for by name
/// @throws core::InputError for a name that there is not, with the nearest one that there is
std::vector<core::Model> choose_models(const std::vector<std::string> &wanted, const models::ModelOptions &options,
                                       bool with_uncertainty);

/// The one that scales loads; every choice of models has it.
const core::Model &baseline_of(const std::vector<core::Model> &models);

/// Lets every model solve a problem and compares it with the reference: with the refined one if that was solved and the
/// other is not good enough, see results::estimate_uncertainty(). A model that finds no solution is part of the result;
/// where the reference finds none, nothing is compared.
/// Of several MPI ranks all call this; the collective models run on all of them and first, so that no failure of
/// another model leaves a rank waiting. The others run on rank 0, which alone compares.
/// @param starting  called with the name of each model before it starts
results::Result hold_contest(const core::Problem &problem, const std::vector<core::Model> &models,
                             const results::ErrorBands &bands, results::Provenance provenance,
                             const std::function<void(const std::string &)> &starting);

} // namespace livermark::app
