#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/solution.hpp"
#include "results/records/result.hpp"

/// Errors of models over the bodies of a cohort: many bodies of one kind whose names end in their number.
namespace livermark::results {

/// An interval that holds a statistic of the population with a probability of 95 %.
struct Interval {
    double low = 0.0;
    double high = 0.0;
};

/// Percentile bootstrap of a quantile (Efron 1979, Annals of Statistics 7(1)): 2.5 to 97.5 % of the quantiles of 2000
/// samples with replacement. The seed is fixed, so the same values give the same interval.
/// Of one body or two it says nothing, see fewest_bodies_of_interval.
Interval bootstrap_interval(const std::vector<double> &values, double part);

/// An interval is given for at least this many bodies: the smallest and the largest of n values hold the median of the
/// population with a probability of 1 - 2^(1 - n) (the sign test's interval), which is 94 % of five bodies and 97 % of
/// six. The upper end of the interval of a 95th percentile is the worst body's as long as there are fewer than 59.
inline constexpr std::size_t fewest_bodies_of_interval = 6;

/// Half of the cohort that a body is in: "training" if its name ends in an odd number, "unseen" if in an even one;
/// nothing if it ends in none. Constants of models may be chosen on the training half, and accuracy is quoted on the
/// unseen one.
std::optional<std::string> cohort_half(const std::string &body);

/// How far one model is off on one body under one load case.
struct CohortError {
    std::string body;
    core::Regime regime = core::Regime::small;
    double poisson_ratio = 0.0; ///< of the first region
    std::string load_case;
    std::string model;
    core::SolutionStatus status = core::SolutionStatus::ok;
    double relative_l2 = 0.0;    ///< as in its comparison with the reference; NaN where it was not compared
    double reaction_error = 0.0; ///< the same
    /// core::ToolComparison::worst_stiffness(); NaN also where the load case has no tool.
    double stiffness = std::numeric_limits<double>::quiet_NaN();
    std::string reference{}; ///< that it was compared with; empty where nothing was, and in older files
    /// core::radius_in_edges() of the load case on the body; NaN where it has no tool, and in older files.
    double tool_radius_in_edges = std::numeric_limits<double>::quiet_NaN();
};

/// One for each model that was compared or has not come to an end. Bodies that are in no half, load cases that depend
/// on time, multiples of a load case, and what leaves its regime or ends at rest (see one_reference.hpp) are left out.
std::vector<CohortError> cohort_errors(std::span<const Result> results);

struct BodyMean {
    std::string body;
    double error; ///< mean over load cases of relative_l2
    /// Mean over load cases of the absolute value of stiffness, where there is one; NaN where there is none.
    double stiffness = std::numeric_limits<double>::quiet_NaN();
};

/// What the errors of one model come to over the bodies of one half.
struct CohortStatistics {
    core::Regime regime = core::Regime::small;
    std::string reference; ///< that all were compared with
    std::string half;
    double poisson_ratio = 0.0;
    std::string model;
    std::vector<BodyMean> means; ///< by name of the body, those that are left out missing
    int left_out = 0;            ///< bodies where the model has not come to an end, or that lack a load case of others
    double median = 0.0;         ///< of the means, like all that follows; NaN where there are none
    Interval median_interval;    ///< NaN where there are fewer bodies than fewest_bodies_of_interval, like the next
    double percentile_95 = 0.0;
    Interval percentile_95_interval;
    double worst = 0.0;
    double stiffness_median = 0.0;      ///< of the means of stiffness, like the next two; NaN where there are none
    Interval stiffness_median_interval; ///< NaN where fewer bodies than fewest_bodies_of_interval have such a mean
    double stiffness_worst = 0.0;
};

/// In the order of regime, reference, half, Poisson's ratio and model. What has not come to an end where nothing was
/// compared counts beside the first reference of its regime and ratio. Where a body, load case and model are there
/// twice, the last counts.
std::vector<CohortStatistics> cohort_statistics(std::span<const CohortError> errors);

} // namespace livermark::results
