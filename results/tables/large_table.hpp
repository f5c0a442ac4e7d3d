#pragma once

#include <span>
#include <string>
#include <vector>

#include "results/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Those of one regime: what is judged by linear elasticity never stands beside what is judged by hyperelasticity.
std::vector<Result> of_regime(std::span<const Result> results, core::Regime regime);

/// One row per body, load case and model of the large regime: displacement, position of tumours, reactions, volume and
/// the shape of tetrahedra, see core::PathComparison and core::Deformation.
Layout large_table(std::span<const Result> results);

/// What its columns mean.
std::string large_legend();

/// What a model feels where a constraint moves, along its way.
struct ForceCurve {
    std::string place; ///< name of the constraint
    double way = 0.0;  ///< the whole of it [m]
    std::string model;
    std::vector<double> force; ///< at each point of the path that the model came to [N]
};

/// Of each constraint that moves and each model; constraints that only hold have none.
std::vector<ForceCurve> force_curves(const Result &result);

/// A row for each of these curves.
Layout force_table(std::span<const Result> results);

} // namespace livermark::results
