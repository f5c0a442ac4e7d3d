#pragma once

#include "results/records/experiment.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Root mean square errors in millimetres, a column for each state: first what stands without a model (the noise of the
/// measurement, a body that does not move, the rigid motion that fits best, the straight line between driven places),
/// then the reference on the refined mesh with its own uncertainty, then the models on the mesh, the best first, with
/// the time of all states. A model without a solution has the word for its status behind the error.
Layout experiment_table(const ExperimentResult &result);

} // namespace livermark::results
