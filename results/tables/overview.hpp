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

/// Error against cost at rest. One row per body_label() and model that moves in time, in the order in which they
/// appear: the means over the load cases that count (see counts_in_means()) of the relative L2 error of the static
/// solution [%] and of the absolute value of stiffness_at_tool() [%]; the time step, 0.8 of the shortest critical one
/// over the load cases, or that of its history [ms]; and the seconds of one core that a simulated second takes with it.
/// The Pareto front of each body is marked. Of several runs of one load case the last one's error counts.
Layout static_accuracy(std::span<const Result> results);

/// Error against cost in motion. One row per body_label(), load case, model, integrator and time step: the relative L2
/// error of the history [%] and the seconds of one core that a simulated second took; and how uncertain the motion is
/// that it is compared with [%], and whose that is. The Pareto front of each body and load case is marked. Results of
/// one problem may come from several runs.
Layout motion_accuracy(std::span<const Result> results);

} // namespace livermark::results
