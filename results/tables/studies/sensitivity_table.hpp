#pragma once

#include "results/records/sensitivity.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each output: its value as the files have it, mean and standard deviation of the samples, between which
/// values 95 % of them are, and the part of the variance that the polynomial misses. Stiffness [N/m], displacements
/// [mm].
Layout output_table(const Sensitivity &sensitivity);

/// A row for each parameter: its range, and of each output the first-order and the total Sobol index with intervals.
Layout index_table(const Sensitivity &sensitivity);

/// A row for each output [%]: mesh, law, measurement, the error of each model, and what the patient makes uncertain:
/// each group of parameters alone, all together, and all but the most important parameter. Errors of models are signed,
/// all else is a size; uncertainties of the patient are standard deviations over the mean.
Layout budget_table(const Sensitivity &sensitivity);

} // namespace livermark::results
