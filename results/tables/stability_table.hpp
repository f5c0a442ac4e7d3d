#pragma once

#include "results/hdf5/stability_file.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// One row per integrator: the longest stable step without and with damping, predicted and observed [ms], and the
/// difference of the observed from the predicted one [%]. "none" where no step is stable, "any" where every one is,
/// "not observed" where nobody looked or nobody could see.
Layout stability_table(const Stability &stability);

} // namespace livermark::results
