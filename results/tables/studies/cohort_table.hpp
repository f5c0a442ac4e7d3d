#pragma once

#include <span>

#include "results/records/cohort.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// One row per half, Poisson's ratio and model. Of each body the mean over load cases of the relative L2 error is
/// taken; the columns are the number of bodies, those that are left out (see CohortStatistics), the median over bodies
/// with its interval, the 95th percentile with its interval, and the worst body [%]; and of the mean over load cases of
/// the absolute value of the stiffness at the tool the median with its interval, and the worst body [%]. Few bodies
/// have no interval, see fewest_bodies_of_interval.
/// @param statistics  of one regime and reference
Layout cohort_table(std::span<const CohortStatistics> statistics);

} // namespace livermark::results
