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
/// load cases of the relative L2 error [%] and that of the absolute stiffness at the tool [%], as in median_errors(),
/// with a sign where all load cases have the same.
Layout brief(std::span<const Result> results);

/// The best three spring models of a body: those whose larger number is smallest, so that both are good.
struct BestSprings {
    std::string body;
    std::vector<BriefNumbers> models;
    bool has_tools = false; ///< whether any of its springs has a stiffness at the tool
};

/// Of each body with springs.
std::vector<BestSprings> best_springs(std::span<const Result> results);

/// Lines on the best springs of each body, and on what the columns mean.
std::string brief_legend(std::span<const Result> results);

} // namespace livermark::results
