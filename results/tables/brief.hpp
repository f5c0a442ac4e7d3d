#pragma once

#include <span>
#include <string>
#include <vector>

#include "results/records/result.hpp"
#include "results/tables/median_errors.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Both numbers of one model on one body.
struct BriefNumbers {
    std::string body; ///< with its Poisson's ratio where there are several
    std::string model;
    TwoNumbers numbers;
};

/// Of each body all models that any of them has, in the order in which they appear.
std::vector<BriefNumbers> brief_numbers(std::span<const Result> results);

/// A row for each model and two columns for each body, at each Poisson's ratio if there are several: the median over
/// load cases of the relative L2 error [%] and that of the absolute stiffness at the tool [%], as in median_errors().
Layout brief(std::span<const Result> results);

/// Lines on the best three spring models of each body by either number, and on what the columns mean.
std::string brief_legend(std::span<const Result> results);

} // namespace livermark::results
