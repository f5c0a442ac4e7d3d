#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/solution.hpp"
#include "results/result.hpp"

/// Errors of models over the bodies of a cohort: many bodies of one kind whose names end in their number.
namespace livermark::results {

/// An interval that holds a statistic of the population with a probability of 95 %.
struct Interval {
    double low = 0.0;
    double high = 0.0;
};

/// Percentile bootstrap of a quantile (Efron 1979, Annals of Statistics 7(1)): 2.5 to 97.5 % of the quantiles of 2000
/// samples with replacement. The seed is fixed, so the same values give the same interval.
Interval bootstrap_interval(const std::vector<double> &values, double part);

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
};

/// One for each model that was compared or has not come to an end. Bodies that are in no half, load cases that depend
/// on time, and multiples of a load case are left out.
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
    std::string half;
    double poisson_ratio = 0.0;
    std::string model;
    std::vector<BodyMean> means; ///< by name of the body, those that are left out missing
    int left_out = 0;            ///< bodies where the model has not come to an end, or that lack a load case of others
    double median = 0.0;         ///< of the means, like all that follows; NaN where there are none
    Interval median_interval;
    double percentile_95 = 0.0;
    Interval percentile_95_interval;
    double worst = 0.0;
    double stiffness_median = 0.0; ///< of the means of stiffness, like the next two; NaN where there are none
    Interval stiffness_median_interval;
    double stiffness_worst = 0.0;
};

/// In the order of regime, half, Poisson's ratio and model. Where a body, load case and model are there twice, the last
/// counts.
std::vector<CohortStatistics> cohort_statistics(std::span<const CohortError> errors);

} // namespace livermark::results
