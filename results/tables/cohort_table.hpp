#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "results/result.hpp"
#include "results/tables/table_layout.hpp"

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

/// One row per half, Poisson's ratio and model. Of each body the mean over load cases of the relative L2 error is
/// taken; the columns are the number of bodies, the median over them with its interval, the 95th percentile with its
/// interval, and the worst body [%]. A body where a model has not come to an end, or lacks a load case that another
/// body has, is counted under "left out". Bodies that are in no half, load cases that depend on time, and multiples of
/// a load case are not in the table.
Layout cohort_table(std::span<const Result> results);

} // namespace livermark::results
