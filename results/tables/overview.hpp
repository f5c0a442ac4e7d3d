#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// The name of the body of a result, with Poisson's ratio of its first region where the results have it with several.
std::string body_label(const Result &result, std::span<const Result> all);

/// The names of bodies and the names of their models, each pair once: bodies by their names, models in the
/// order in which they appear.
/// @param takes_part  whether a result takes part; all do if there is none
std::vector<std::pair<std::string, std::string>> bodies_and_models(std::span<const Result> results,
                                                                   bool (*takes_part)(const Result &) = nullptr);

/// Whether a body is there with several Poisson's ratios.
bool has_several_poisson_ratios(std::span<const Result> results);

/// The error of the reactions; nothing where there is no resultant, and where one place holds the body against loads
/// that are given, so that every model has the same resultant.
std::optional<double> told_reaction_error(const core::Comparison &comparison, const Result &result);

/// One row per body and model, in the order in which they appear, and for each Poisson's ratio over all load cases that
/// count (see counts_in_means()), with their number behind the mean of a model that has not solved all of them: the
/// mean and the worst relative L2 error of the static solution [%], those of the absolute value of stiffness_at_tool()
/// [%], the mean and the worst error of the reactions [%]
/// and the shortest critical time step of explicit stepping [ms]; at the end the time that such a step takes [us]. The
/// reference has its own uncertainty for an error. A load case that did not come to an end makes the mean "-" and its
/// status the worst.
Layout overview(std::span<const Result> results);

/// One row per model and two columns per body_label(), in the order in which they appear: the means over the load cases
/// of the relative L2 error of the static solution and of the absolute value of stiffness_at_tool() [%], as in
/// overview().
Layout mean_errors(std::span<const Result> results);

} // namespace livermark::results
