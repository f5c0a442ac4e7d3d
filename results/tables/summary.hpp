#pragma once

#include <span>

#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// One row per body and model, in the order in which they appear: relative L2 error of the static solution in each load
/// case
/// [%] and their mean over those that count (see counts_in_means()), with their number where a model has not solved all
/// of them; the reference's own mean uncertainty [%]; the worst error of the reactions [%]; and the mean of
/// the seconds that a load case takes once everything is set up. A model that is the reference in a load case has
/// "reference" there, "not compared" if that has found no solution, and " !" behind its error where the load leaves its
/// regime; what did not come to an end has its status.
Layout summary(std::span<const Result> results);

} // namespace livermark::results
