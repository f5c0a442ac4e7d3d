#pragma once

#include <span>
#include <string>

#include "results/hdf5/files/history_file.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// What became of a motion: "diverged at 0.5 s", "stable, ends at 8e-05 m", or "grows, ..." where the step is longer
/// than the longest stable one and nothing has diverged yet.
std::string verdict(const StepHistory &history, double critical_time_step);

/// One row per case: its longest stable step [s], and the verdict of each step. Steps that all cases have, which are
/// those that were asked for, have a column of their own; the last column is what a body took besides.
Layout history_table(std::span<const Histories> all);

} // namespace livermark::results
