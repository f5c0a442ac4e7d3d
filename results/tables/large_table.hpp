#pragma once

#include <span>
#include <string>
#include <vector>

#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// One row per body, load case and model of the large regime: displacement, position of tumours, reactions, volume and
/// the shape of tetrahedra, see core::PathComparison and core::Deformation.
Layout large_table(std::span<const Result> results);

/// Meaning of its columns.
std::string large_legend();

/// Force against way of a place, at each point of the path that a model came to.
struct ForceCurve {
    std::string place; ///< name of the constraint that moves, or "load"
    std::string model;
    std::vector<double> way;   ///< of the place [m]
    std::vector<double> force; ///< along it [N]
};

/// Curves of each constraint that moves and each model: the prescribed way with the force of the model; constraints
/// that only hold have none. Of tractions that keep their direction, where they have a resultant, the given force with
/// the way of the model: the mean displacement of the places, weighted with the traction, along the resultant.
std::vector<ForceCurve> force_curves(const Result &result);

/// A row for each of these curves.
Layout force_table(std::span<const Result> results);

/// Load cases in which time passes in the material, others are left out: a row for each model and tool, with the
/// force at the whole load when it is first reached, at the last record of the whole load and what that is of the
/// first; how far the force over time is from that of the reference; and the heat of the last cycle. Of a given
/// traction the displacement takes the place of the force.
Layout slow_table(std::span<const Result> results);

/// Meaning of its columns.
std::string slow_legend();

} // namespace livermark::results
