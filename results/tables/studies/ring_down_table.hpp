#pragma once

#include "results/records/experiment.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Of all ring-downs of an experiment: for each the measured frequency and damping ratio with their uncertainty, the
/// noise, what stands without a model, and a row for each model, the smallest error of the markers first.
Layout ring_down_table(const ExperimentResult &result);

/// On which state damping was fitted, and what all models were given for it; the last run is of the reference.
std::string ring_down_note(const ExperimentResult &result);

} // namespace livermark::results
