#pragma once

#include <span>
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

/// A row for each constraint that moves, and model: the force along its way at each point of the path [N], and the
/// whole way [mm]. Constraints that only hold are left out, and so are load cases without others.
Layout force_curves(std::span<const Result> results);

} // namespace livermark::results
