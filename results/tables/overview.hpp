#pragma once

#include <cstddef>
#include <limits>
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

/// A row for each body and model and columns for each Poisson's ratio, over the load cases that count
/// (counts_in_means()); stiffness_at_tool() in absolute value. The reference has its own uncertainty for an error. A
/// load case that did not come to an end makes the mean "-" and its status the worst.
Layout overview(std::span<const Result> results);

/// The two means of overview(), in columns for each body_label().
Layout mean_errors(std::span<const Result> results);

/// Cost and error; NaN where that is not known.
struct CostAndError {
    double cost;
    double error;
};

/// Membership of the Pareto front: no other is at least as good in both and better in one. What has a NaN is
/// not.
/// @return shape of points
std::vector<bool> pareto_front(std::span<const CostAndError> points);

/// The place of a model among those of one body, or of one body and load case.
struct Standing {
    std::string body;      ///< body_label()
    std::string load_case; ///< empty for the mean over all
    std::string model;
    std::string integrator; ///< of a history, else empty
    double time_step;       ///< [s]; NaN where that is not known
    CostAndError at;        ///< seconds of one core per simulated second, relative L2 error
    bool is_on_front;
    /// Error of the motion that it is compared with, relative L2; NaN where that is not known, and at rest.
    double uncertainty = std::numeric_limits<double>::quiet_NaN();
    /// At rest the mean over the same load cases of the absolute value of stiffness_at_tool(); NaN where it is not
    /// known.
    double stiffness = std::numeric_limits<double>::quiet_NaN();
    /// At rest, over how many load cases of how many of the body the mean is; equal in motion. Who has not solved all
    /// is not ranked, and does not push others from the front.
    std::size_t num_cases = 1, num_in_table = 1;
    std::string reference{}; ///< whose motion a motion is compared with; empty at rest

    bool is_ranked() const { return num_cases == num_in_table; }
};

/// The rows of static_accuracy() as numbers.
std::vector<Standing> standings_at_rest(std::span<const Result> results);

/// The rows of motion_accuracy() as numbers.
std::vector<Standing> standings_in_motion(std::span<const Result> results);

/// Error against cost at rest, a row for each body_label() and model that moves in time: means over the load cases that
/// count, with 0.8 of the shortest critical step over the load cases, or the step of its history. Of several runs of
/// one load case the last one's error counts.
Layout static_accuracy(std::span<const Result> results);

/// The same of motions, a row for each load case, integrator and step. Results of one problem may come from several
/// runs.
Layout motion_accuracy(std::span<const Result> results);

} // namespace livermark::results
