#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Whether a pressure acts on the whole free surface: every boundary triangle either has a prescribed displacement or a
/// traction along its normal, and at least one has a traction. Such a load changes the volume, and its error shows
/// Poisson's ratio before all else.
/// @param load_case  of the mesh
bool is_pressure_on_whole_surface(const core::LoadCase &load_case, const core::TetraMesh &mesh);

/// A row for each body and model, and four columns for each Poisson's ratio, the largest first: medians over the load
/// cases that count (counts_in_means()), stiffness_at_tool() in absolute value. Load cases with pressure on the whole
/// free surface have a column of their own, and no part in the others.
///
/// The reference has "+-" and the median of its own uncertainty. A model whose median is below that has a star, unless
/// it has not solved all load cases, whose number is behind it then: "5.32 (3 of 11)". Of several results for one body,
/// Poisson's ratio and load case the last one counts.
Layout median_errors(std::span<const Result> results);

/// The two numbers that lead every table, of one model on one body.
struct TwoNumbers {
    /// Cells of median_errors(), the stiffness with a sign where that of all load cases is the same.
    std::string error, stiffness;
    /// For an order: the median of the relative L2 error and that of the absolute stiffness at the tool; NaN where
    /// there is none.
    double median_error, median_stiffness;
    bool is_spring_model;

    /// The larger of the two medians; NaN where one is. Models without any stiffness at the tool go by the other.
    double larger(bool has_tools) const;
};

/// Numbers of median_errors() for a model; of a body with nothing but pressure on its surface the error is that one.
TwoNumbers two_numbers(std::span<const Result> results, const std::string &body, double poisson_ratio,
                       const std::string &model);

/// Whether median_errors() has anything to take a median over: several load cases of one body at one Poisson's ratio.
bool has_several_load_cases(std::span<const Result> results);

/// Sentences on the columns and marks of median_errors(), with the names of the load cases.
std::string median_legend(std::span<const Result> results);

/// Both numbers of one model on one body.
struct BriefNumbers {
    std::string body; ///< with its Poisson's ratio where there are several
    std::string model;
    TwoNumbers numbers;
};

/// Numbers of each body and each model that any body has, in the order in which they appear.
std::vector<BriefNumbers> brief_numbers(std::span<const Result> results);

/// A row for each model and two columns for each body, at each Poisson's ratio if there are several: the median over
/// load cases of the relative L2 error [%] and that of the absolute stiffness at the tool [%], as in median_errors(),
/// with a sign where all load cases have the same.
Layout brief(std::span<const Result> results);

/// The best three spring models of a body: those whose larger number is smallest, so that both are good.
struct BestSprings {
    std::string body;
    std::vector<BriefNumbers> models;
    bool has_tools = false; ///< whether any of its springs has a stiffness at the tool
};

/// The best springs of each body that has springs.
std::vector<BestSprings> best_springs(std::span<const Result> results);

/// Lines on the best springs of each body, and on what the columns mean.
std::string brief_legend(std::span<const Result> results);

} // namespace livermark::results
